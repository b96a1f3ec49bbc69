"""Fixtures of the tests that open the viewer's page."""

from tests.support.page_renderers import painters
from tests.support.three_page import pages
from tests.support.viewer_page import served

__all__ = ["pages", "painters", "served"]
