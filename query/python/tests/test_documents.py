"""What the guide shows runs as it stands, and every name has a docstring that says what is needed."""

from __future__ import annotations

import inspect
import re
import shutil
from pathlib import Path

import pytest
from conftest import ROOT

import grasp

GUIDE = ROOT / "docs" / "python.md"


def test_what_the_guide_shows_runs(index_path, monkeypatch, tmp_path):
    blocks = re.findall(r"^```python\n(.*?)^```$", GUIDE.read_text(), flags=re.DOTALL | re.MULTILINE)
    assert len(blocks) >= 5
    for name in ("tests", "query"):
        (tmp_path / name).symlink_to(ROOT / name)
    shutil.copy(index_path, tmp_path / "grasp.idx")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for number, block in enumerate(blocks):
        exec(compile(block, f"{GUIDE.name}, block {number}", "exec"), names)


def public():
    for name in grasp.__all__:
        thing = getattr(grasp, name)
        yield name, thing
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            for part, member in vars(thing).items():
                if not part.startswith("_"):
                    yield f"{name}.{part}", member


@pytest.mark.parametrize(("name", "thing"), list(public()), ids=lambda value: value if isinstance(value, str) else "")
def test_docstrings(name, thing):
    documentation = inspect.getdoc(thing)
    assert documentation, name
    first = documentation.splitlines()[0]
    assert first.endswith(".") and len(first) <= 100, f"{name}: {first}"
    assert max(map(len, documentation.splitlines())) <= 100, name
    if callable(thing) and not inspect.isclass(thing):
        parameters = [part for part in inspect.signature(thing).parameters if part != "self"]
        missing = [part for part in parameters if not re.search(rf"^{part} : ", documentation, re.MULTILINE)]
        assert not missing, f"{name} does not say what {missing} mean"


def test_the_package_is_typed():
    folder = Path(grasp.__file__).parent
    assert (folder / "py.typed").exists() and (folder / "_native.pyi").exists()
