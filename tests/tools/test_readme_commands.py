"""Which blocks of a page are run, and what a failing one does."""

from pathlib import Path

import pytest
from tools.readme_commands import blocks, run_blocks

PAGE = """
```bash
echo one > file
```
<!-- not run: would fail -->
```bash
false
```
```
no language
```
```python
assert open("file").read() == "one\\n"
```
"""


def test_blocks_run_in_order_in_one_folder(tmp_path: Path) -> None:
    assert [language for language, _ in blocks(PAGE)] == ["bash", "python"]
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    assert run_blocks(page) == 0


def test_the_first_failure_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.md"
    page.write_text("```bash\nexit 3\n```\n")
    assert run_blocks(page) == 3
    assert "status 3" in capsys.readouterr().err
