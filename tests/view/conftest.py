"""What tests of pages share."""

from collections.abc import Iterator
from typing import Any

import pytest


@pytest.fixture(scope="module")
def sheet(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """An empty page of a browser with an empty profile."""
    from tests.view.browser import browser  # skips what imports it where there is no browser

    with browser(tmp_path_factory.mktemp("profile")) as context:
        yield context.pages[0]
