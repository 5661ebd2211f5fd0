"""Which Python of a page is type-checked, and where its errors are said to be."""

from pathlib import Path

import pytest
from tools.check_types import check, module_of

PAGE = """# Title
```python
import math
```
```bash
echo not Python
```
```python
print(math.sqrt({value}))
```
"""


def test_blocks_are_one_module_line_by_line() -> None:
    lines, page = module_of(PAGE).splitlines(), PAGE.splitlines()
    kept = [number for number, line in enumerate(lines) if line]
    assert [lines[number] for number in kept] == ["import math", "print(math.sqrt({value}))"]
    assert all(lines[number] == page[number] for number in kept)


def test_a_wrong_type_on_a_page_is_told_with_its_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    good, bad = tmp_path / "good.md", tmp_path / "bad.md"
    good.write_text(PAGE.format(value=2.0))
    bad.write_text(PAGE.format(value="'two'"))
    assert check([good]) == 0
    assert check([bad]) == 1
    said = capfd.readouterr().out
    assert "bad_page.py:9: error" in said  # mypy's words
    assert "bad_page.py:9:17 - error" in said  # Pyright's
