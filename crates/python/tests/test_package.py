"""The package as it is installed: the program, the examples in docs, and types."""

import ast
import doctest
import inspect
import pathlib
import subprocess
import sys
import urllib.request

import pytest
import usarsim

PACKAGE = pathlib.Path(usarsim.__file__).parent
BOOK = pathlib.Path(__file__).parents[3] / "docs"


def run(*arguments, **options):
    return subprocess.run([sys.executable, "-m", "usarsim", *arguments], capture_output=True, text=True, **options)


def test_the_program_comes_with_the_package():
    shown = run("robots")
    assert shown.returncode == 0 and "KUKA_YouBot" in shown.stdout
    wrong = run("show", "robot", "NoBot")
    assert wrong.returncode == 78 and "NoBot" in wrong.stderr
    assert run("--version").stdout.strip() == f"usarsim {usarsim.__version__}"
    assert run("nonsense").returncode == 2
    script = pathlib.Path(sys.executable).with_name("usarsim")
    if script.exists():
        assert subprocess.run([script, "maps"], capture_output=True).returncode == 0


def test_the_server_serves_its_page_and_stops_on_ctrl_c():
    import json
    import signal

    command = [sys.executable, "-m", "usarsim", "serve", "--port", "0", "--http", "0", "--json"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        ready = json.loads(server.stdout.readline())
        page = urllib.request.urlopen(f"http://127.0.0.1:{ready['http']}/", timeout=10).read()
        assert b"<html" in page.lower()
    finally:
        server.send_signal(signal.SIGINT)
    assert server.wait(10) == 0


def stubs():
    """Every docstring of the type stubs, with its name."""
    tree = ast.parse((PACKAGE / "_native.pyi").read_text())
    for node in ast.walk(tree):
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node):
            yield node.name, ast.get_docstring(node)


def check(name, text, names):
    test = doctest.DocTestParser().get_doctest(text, names, name, name, 0)
    report = []
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    doctest.DocTestRunner(optionflags=flags).run(test, out=report.append)
    assert not report, "".join(report)
    return len(test.examples)


def test_examples_in_docstrings_run():
    import numpy as np

    ran = sum(check(name, text, {"usarsim": usarsim, "np": np}) for name, text in stubs())
    modules = [usarsim]
    for name in ("gym", "pettingzoo"):
        try:
            modules.append(__import__(f"usarsim.{name}", fromlist=[name]))
        except ImportError:
            pass
    for module in modules:
        ran += check(module.__name__, inspect.getdoc(module) or "", {})
    ran += check("describe", inspect.getdoc(usarsim.describe), vars(usarsim).copy())
    assert ran > 10


@pytest.mark.parametrize("page", ["howto-python.md", "howto-learning.md"])
def test_examples_in_the_book_run(page):
    path = BOOK / page
    if not path.exists():
        pytest.skip(f"no {path}: the package is tested without its repository")
    blocks = path.read_text().split("```python\n")[1:]
    text = "\n".join(block.split("```")[0] for block in blocks)
    if "gymnasium" in text:
        pytest.importorskip("gymnasium")
    assert check(page, text, {}) > 5


def test_the_stubs_have_every_name():
    declared = {
        node.name
        for node in ast.parse((PACKAGE / "_native.pyi").read_text()).body
        if isinstance(node, (ast.ClassDef, ast.FunctionDef))
    }
    from usarsim import _native

    assert {name for name in dir(_native) if not name.startswith("__")} <= declared
    assert (PACKAGE / "py.typed").exists()
