"""What a fork server forks is what a process of its own would be: arguments, variables, limits,
files, exit code; and it ends when whoever started it does."""

import json
import os
import resource
import signal
import subprocess
import sys
import time

import pytest

from softact.child_processes import bound, environment, python
from softact.forkserver import client, servers
from softact.run.start import run
from softact.spec import loads

# Tells what it is; its first argument says how it ends.
SCRIPT = """
import json, os, resource, signal, sys, tempfile, time
LOADED = []
def preload():
    import xmlrpc.client
if __name__ == "__main__":
    told = {
        "arguments": sys.argv[1:], "folder": os.getcwd(), "tmp": tempfile.gettempdir(),
        "variable": os.environ.get("OMPI_OF_A_TEST"), "missing": os.environ.get("HOME"),
        "limit": resource.getrlimit(resource.RLIMIT_FSIZE), "umask": os.umask(0),
        "stdin": sys.stdin.read(), "session": os.getsid(0) == os.getpid(),
        "encoding": sys.stdout.encoding, "preloaded": "xmlrpc.client" in sys.modules,
        "file": os.read(int(sys.argv[2]), 100).decode() if len(sys.argv) > 2 else "",
        "cores": sorted(os.sched_getaffinity(0)), "name": __name__,
    }
    print(json.dumps(told), flush=True)
    print("noise", file=sys.stderr)
    match sys.argv[1]:
        case "raise": raise KeyError("a fault")
        case "text": sys.exit("a last word")
        case "signal": os.kill(os.getpid(), signal.SIGSEGV)
        case "wait": time.sleep(600)
        case number: sys.exit(int(number))
"""


@pytest.fixture
def script(tmp_path):
    file = tmp_path / "told.py"
    file.write_text(SCRIPT, encoding="utf-8")
    return file


@pytest.fixture
def forked():
    """``servers.command``, of servers of the test's own, whose answer has a server in it."""
    own = servers._Servers()

    def command(arguments, variables):
        own.name([str(a) for a in arguments], variables)
        name = own.name([str(a) for a in arguments], variables)
        assert name is not None
        return [sys.executable, "-I", "-S", servers._CLIENT, name, *python(*arguments)]

    command.own = own
    yield command
    own.end()


def both(forked, script, *arguments, **how):
    """What is started does by itself, and forked."""
    variables = how.pop("env", None) or environment()
    done = []
    for command in (python(script, *arguments), forked([script, *arguments], variables)):
        done.append(
            subprocess.run(
                command, capture_output=True, text=True, env=variables, check=False, **how
            )
        )
    return done


def limited():
    os.umask(0o27)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10**6, 10**6))


def test_it_has_what_the_client_has(forked, script, tmp_path):
    ours, theirs = os.pipe()
    variables = environment() | {"OMPI_OF_A_TEST": "ä", "TMPDIR": str(tmp_path)}
    variables.pop("HOME", None)
    told = []
    for command in (python, lambda *a: forked(list(a), variables)):
        os.write(theirs, b"handed over")
        done = subprocess.run(
            command(script, "0", str(ours)), input="a job", capture_output=True, text=True,
            env=variables, cwd=tmp_path, pass_fds=(ours,), start_new_session=True,
            preexec_fn=limited,
            check=True,
        )  # fmt: skip
        told.append(json.loads(done.stdout))
    os.close(ours)
    os.close(theirs)
    assert told[1].pop("preloaded") and not told[0].pop("preloaded")
    assert told[1] == told[0]
    assert told[1]["stdin"] == "a job" and told[1]["file"] == "handed over"
    assert told[1]["limit"] == [10**6, 10**6] and told[1]["umask"] == 0o27
    assert told[1]["variable"] == "ä" and told[1]["missing"] is None


@pytest.mark.parametrize("how", ["0", "3", "raise", "text", "signal"])
def test_it_ends_as_it_would_by_itself(forked, script, how):
    alone, through = both(forked, script, how, stdin=subprocess.DEVNULL)
    assert through.returncode == alone.returncode
    assert through.returncode == {"0": 0, "3": 3, "signal": -signal.SIGSEGV}.get(how, 1)
    assert through.stderr.splitlines()[0] == alone.stderr.splitlines()[0] == "noise"
    assert through.stderr.splitlines()[-1] == alone.stderr.splitlines()[-1]


def waiting(forked, script, command=lambda c: c):
    """A client whose forked process waits, and the id of that process."""
    file = script.with_suffix(".pid")
    script.write_text(
        f"import os, time\nif __name__ == '__main__':\n"
        f"    open({str(file)!r} + '.new', 'w').write(str(os.getpid()))\n"
        f"    os.rename({str(file)!r} + '.new', {str(file)!r})\n    time.sleep(600)\n"
    )
    variables = environment()
    process = subprocess.Popen(command(forked([script], variables)), env=variables)
    until(file.exists)
    return process, int(file.read_text())


def until(holds):
    for _ in range(1000):
        if holds():
            return
        time.sleep(0.02)
    raise AssertionError("it did not come about")


def is_running(process):
    try:
        with open(f"/proc/{process}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_it_ends_with_its_client(forked, script, number):
    process, inner = waiting(forked, script)
    assert inner != process.pid and is_running(inner)
    process.send_signal(number)
    assert process.wait() == -number
    until(lambda: not is_running(inner))


def test_it_and_its_client_end_with_the_server(forked, script):
    process, inner = waiting(forked, script)
    ((_, server),) = forked.own._running.values()
    server.kill()
    assert process.wait() == -signal.SIGKILL
    until(lambda: not is_running(inner))


def test_all_end_with_who_started_the_server(script, tmp_path):
    starter = tmp_path / "starter.py"
    starter.write_text(
        "import subprocess, sys\nfrom softact.child_processes import bound, environment\n"
        "from softact.forkserver import command\nv = environment()\ncommand(sys.argv[1:], v)\n"
        "subprocess.run(bound(command(sys.argv[1:], v)), env=v)\n"
    )

    def started(arguments, variables):
        return [sys.executable, str(starter), *map(str, arguments)]

    process, inner = waiting(started, script)
    with open(f"/proc/{inner}/stat") as file:
        server = int(file.read().rpartition(")")[2].split()[1])
    process.kill()
    process.wait()
    until(lambda: not is_running(inner) and not is_running(server))


def test_without_a_server_the_client_becomes_the_process(script):
    variables = environment()
    command = [sys.executable, "-I", "-S", servers._CLIENT, "softact-gone", *python(script, "3")]
    done = subprocess.run(
        bound(command), capture_output=True, text=True, env=variables, input="job"
    )
    assert done.returncode == 3
    assert json.loads(done.stdout)["stdin"] == "job"


def test_what_libraries_read_when_they_are_loaded_has_a_server_of_its_own(script):
    own = servers._Servers()
    arguments, variables = [str(script)], environment()
    try:
        assert own.name(arguments, variables) is None  # once is not often
        first = own.name(arguments, variables)
        assert own.name([*arguments, "more"], variables | {"TMPDIR": "/elsewhere"}) == first
        other = variables | {"OPENBLAS_NUM_THREADS": "7"}
        assert own.name(arguments, other) is None
        assert own.name(arguments, other) not in (None, first)
    finally:
        own.end()


def test_there_are_not_ever_more_servers(script, monkeypatch):
    monkeypatch.setattr(servers, "MOST", 1)
    own = servers._Servers()
    try:
        names = [own.name([str(script)], {"A": str(n // 2)}) for n in range(4)]
        assert [name is None for name in names] == [True, False, True, True]
    finally:
        own.end()


def test_a_server_that_cannot_load_leaves_the_command_as_it_is(script):
    own = servers._Servers()
    script.write_text("raise ImportError\n")
    arguments = [str(script)]
    assert own.name(arguments, environment()) is None
    assert own.name(arguments, environment()) is not None
    ((_, process),) = own._running.values()
    process.wait()
    assert own.name(arguments, environment()) is None
    own.end()


def test_limits_are_those_of_the_process():
    assert (resource.RLIMIT_CORE, *resource.getrlimit(resource.RLIMIT_CORE)) in client.limits()


BLOCK = """
geometry: {type: block, length: 10 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials: {body: ecoflex-00-30}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [5 kPa, 0 Pa, 1 kPa]}}]
"""


def test_a_forked_solver_and_a_forked_mesher_give_the_same_to_the_last_digit(tmp_path, monkeypatch):
    spec, own = loads(BLOCK), servers._Servers()
    monkeypatch.setattr(servers, "_servers", own)
    curves = []
    for number, most in enumerate((0, 8, 8)):
        monkeypatch.setattr(servers, "MOST", most)
        run(spec, tmp_path / str(number), report=False)
        curves.append((tmp_path / str(number) / "curve.csv").read_text())
    started = [arguments[0][1] for arguments in own._running]
    own.end()
    assert sorted(started) == ["softact.geometry.gmsh_process", "softact.run.worker"]
    assert curves[1] == curves[0] and curves[2] == curves[0]
