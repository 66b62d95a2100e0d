"""Fixtures of several files"""

import pytest


@pytest.fixture
def no_offers(monkeypatch):
    """Reports, of commands too, without the table of what `kalmanq compile` would write: most of their time, and not of their data"""
    from kalmanq.pages import report

    monkeypatch.setattr(report, "offers", lambda model: [])
