"""What is marked `whole` runs with tools/test.sh --all (tools.FILE.whole); the others run every day."""


def pytest_configure(config):
    config.addinivalue_line("markers", "whole: only with tools/test.sh --all")
