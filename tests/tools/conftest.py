"""What is marked `whole` runs with tools/test.sh --all (tools.FILE.whole); the others run every day."""

import pytest


def pytest_configure(config):
    config.addinivalue_line("markers", "whole: only with tools/test.sh --all")


@pytest.fixture
def no_offers(monkeypatch):
    """Reports, of commands too, without the table of what `kalmanq compile` would write: most of their time, and not of their data"""
    from kalmanq.pages import report

    monkeypatch.setattr(report, "offers", lambda model: [])
