"""`import llfbench` gives this package once `install()` was called, and only then."""

import subprocess
import sys


def run(code, folder):
    return subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False)


def test_without_installing_there_is_no_llfbench(tmp_path):
    result = run("import llf_teacher.compat, llfbench", tmp_path)
    assert "No module named 'llfbench'" in result.stderr


def test_modules_resolve_to_ours_and_back(tmp_path):
    code = """if True:
        import sys, llf_teacher.compat as compat
        compat.install(); compat.install()
        assert len([finder for finder in sys.meta_path if type(finder).__module__.startswith("llf_teacher")]) == 1
        import llfbench, llfbench.envs.env_wrappers
        from llfbench.envs.llf_env import LLFWrapper, Feedback
        from llfbench.envs.env_wrappers import TextWrapper, EnvCompatibility
        from llfbench.agents.utils import set_seed
        from llfbench.utils import generate_combinations_dict
        assert (llfbench.make, LLFWrapper, TextWrapper) == (compat.make, compat.LLFWrapper, compat.TextWrapper)
        assert llfbench.envs.env_wrappers.TerminalFreeWrapper is compat.TerminalFreeWrapper
        try:
            import llfbench.envs.gridworld.prompts
        except ModuleNotFoundError as error:
            assert error.name == "llfbench.envs.gridworld.prompts"
            assert "docs/coming-from-llf-bench.md says what is" in str(error)
        else:
            raise AssertionError
        compat.uninstall(); compat.uninstall()
        assert not [name for name in sys.modules if name.startswith("llfbench")]
        try:
            import llfbench
        except ModuleNotFoundError:
            print("gone")
    """
    assert run(code, tmp_path).stdout == "gone\n"


def test_submodules_are_attributes_and_what_is_not_offered_says_so(tmp_path):
    code = """if True:
        import llf_teacher.compat as compat
        compat.install()
        import llfbench as gym
        from llfbench.agents.basic_ai_agent import BasicAIAgent
        from llfbench.agents.user_agent import UserAgent
        assert gym.envs.env_wrappers.TextWrapper is compat.TextWrapper
        assert issubclass(gym.agents.abstract_agent.BasicAgent, gym.agents.abstract_agent.Agent)
        families = "alfworld bandits gridworld highway metaworld optimization poem reco".split()
        makers = [getattr(gym.envs, family).make_env for family in families]
        refused = [BasicAIAgent, UserAgent, gym.agents.llm.make_llm, gym.utils.parser_utils.SimpleGuidanceParser]
        for each in [*refused, gym.envs.utils.format, *makers]:
            for use in (each, lambda: type("Mine", (each,), {})):
                try:
                    use()
                except TypeError as error:
                    assert str(error).startswith(f"{each.__module__}.{each.__name__} is not offered by llf_teacher; ")
                else:
                    raise AssertionError(each)
        print(len(makers), hasattr(gym.envs, "kitchen"))
    """
    result = run(code, tmp_path)
    assert (result.stdout, result.stderr) == ("8 False\n", "")


def test_the_real_one_is_left_alone(tmp_path):
    (tmp_path / "llfbench").mkdir()
    (tmp_path / "llfbench" / "__init__.py").write_text("REAL = True\n")
    code = """if True:
        import llf_teacher.compat
        llf_teacher.compat.install()
        import llfbench
        assert llfbench.REAL and not hasattr(llfbench, "make")
        try:
            import llfbench.utils
        except ModuleNotFoundError:
            print("nothing is mixed in")
        llf_teacher.compat.uninstall()
        import llfbench
        assert llfbench.REAL
    """
    assert run(code, tmp_path).stdout == "nothing is mixed in\n"
