"""The page in headless Chromium."""

from page_fixtures import browser_of, open_page

__all__ = ["browser_of", "open_page"]
