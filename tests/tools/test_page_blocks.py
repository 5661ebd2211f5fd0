"""Which blocks of a page are run, what a failing one does, and that no page has a block which nobody runs."""

from pathlib import Path

import pytest
from tools.page_blocks import all_blocks, blocks, run_all, unexplained

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]

PAGE = """
```bash
echo one > file
```
<!-- not run: would fail -->
```bash
false
```
```text
what is printed
```
```{note}
of the site
```
```python
text = open("file").read()
```
<!-- file: two.yaml -->
```yaml
goal: {x: 1}
```
```python
assert text == "one\\n" and open("two.yaml").read() == "goal: {x: 1}\\n"
```
<!-- part of: wheeled -->
```yaml
horizon: 12
```
"""


def test_blocks_run_in_order_in_one_folder_and_one_interpreter(tmp_path: Path) -> None:
    assert [block.language for block in blocks(PAGE)] == ["bash", "python", "yaml", "python", "yaml"]
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    assert run_all([tmp_path]) == 0


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("```bash\nexit 3\n```\n", "status 3"),
        ("```python\nraise SystemExit(0)\n```\n", "SystemExit"),
        ("```python\n1 / 0\n```\n", 'page.md", line 2'),
        ("<!-- part of: wheeled -->\n```yaml\nhorizont: 12\n```\n", "horizon"),
    ],
)
def test_a_failure_is_told(block: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.md"
    page.write_text(block)
    assert run_all([page]) == 1
    assert said in capsys.readouterr().err


def test_blocks_that_nobody_runs_are_found() -> None:
    assert unexplained(PAGE) == []
    assert len(unexplained("```\nls\n```\n")) == 1
    assert len(unexplained("```cpp\nint i;\n```\n")) == 1
    assert len(unexplained("```yaml\na: 1\n```\n")) == 1
    assert [block.line for block in all_blocks("\n```bash\nls\n```\n")] == [3]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_block_of_the_pages_is_run_or_says_why_not(page: Path) -> None:
    assert unexplained(page.read_text(encoding="utf-8")) == []
