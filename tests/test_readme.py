"""What the README and the pages show runs as written."""

import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(path: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", path.read_text(), re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_python_blocks_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # A module of its own, so that classes defined on a page can be pickled.
    module = ModuleType("page")
    monkeypatch.setitem(sys.modules, "page", module)
    for code in blocks(page, "python"):
        exec(compile(code, str(page), "exec"), module.__dict__)


def test_readme_shows_python_in_five_lines() -> None:
    (code,) = blocks(ROOT / "README.md", "python")
    assert len([line for line in code.splitlines() if line.strip()]) <= 5


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
        if not target.startswith("http"):
            assert (page.parent / target).exists(), target


def test_shown_commands_and_options_exist() -> None:
    from conav.cli.app import app

    makefile = (ROOT / "Makefile").read_text()
    for page in PAGES:
        shown = "\n".join(re.findall(r"```(?:sh)?\n(.*?)```", page.read_text(), re.DOTALL))
        for line in re.findall(r"^(?:\.venv/bin/)?(conav \w+.*|make \w+)", shown, re.M):
            words = line.split("#")[0].split()
            if words[0] == "make":
                assert f"\n{words[1]}:" in makefile, line
                continue
            command = app[words[1]]
            if command.default_command is None:  # it has commands of its own
                command = command[words[2]]
            known = {name for arg in command.assemble_argument_collection() for name in arg.names}
            for word in words[2:]:
                if word.startswith("--") and word != "--help":
                    assert word in known, line


def test_everything_cited_is_in_the_bibliography() -> None:
    known = set(re.findall(r"^- \[(\w+)\]", (ROOT / "docs/bibliography.md").read_text(), re.M))
    for file in [*ROOT.glob("src/**/*.py"), *ROOT.glob("docs/**/*.md")]:
        cited = re.findall(r"\[([A-Z]\w+(?:19|20)\d\d)\]", file.read_text())
        assert set(cited) <= known, file
