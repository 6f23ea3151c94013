"""A guide says what the teacher says of a first turn."""

import subprocess
import sys

from llf_teacher.integrations.trace import TeachingGuide

BOOTH = "llf-optimization-Booth-v0"


def test_it_scores_and_says():
    """A loop as trainers have it: the better answer is paid better, and the feedback names the reward."""
    guide = TeachingGuide(feedback_type="r+fp")
    data = guide.dataset([BOOTH], range(2))
    assert data["infos"] == [(BOOTH, 0), (BOOTH, 1)]
    assert data["inputs"][0] != data["inputs"][1]
    for query, info in zip(data["inputs"], data["infos"], strict=True):
        assert "What do you do in turn 1?" in query
        bad, told = guide.get_feedback(query, "x = [-10.0, -10.0]", info)
        best, praised = guide(query, "Thought: easy.\nResponse: [1.0, 3.0]", info)
        assert bad < best
        assert guide.metric(query, "x = [-10.0, -10.0]", info) == bad
        assert f"{abs(bad):.2f}"[:3] in told
        assert told != praised


def test_what_is_no_action_is_told():
    score, told = TeachingGuide(feedback_type="n").get_feedback("", "hm", (BOOTH, 0))
    assert score <= 0
    assert "hm" in told


def test_it_needs_no_trace():
    program = "import sys, llf_teacher.integrations.trace as t; t.TeachingGuide(); print('opto' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True).stdout == "False\n"
