"""What tests of pages share."""

from collections.abc import Iterator
from typing import Any

import pytest

from rollgait.view import event_loop


@pytest.fixture(autouse=True)
def a_busy_machine_tears_no_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is told to a page in one go is waited for, however long it takes."""
    monkeypatch.setattr(event_loop, "PATIENCE", 300.0)


@pytest.fixture(scope="module")
def sheet(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """An empty page of a browser with an empty profile."""
    from tests.view.browser import browser  # skips what imports it where there is no browser

    with browser(tmp_path_factory.mktemp("profile")) as context:
        yield context.pages[0]
