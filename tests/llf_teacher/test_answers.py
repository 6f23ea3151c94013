"""The first sentence of a report: on twenty studies with a known answer."""

import re

import numpy as np
import pytest
from planted import NO, OPEN, STUDIES, YES
from studying import filled

from llf_teacher.studies.report import findings
from llf_teacher.studies.report.answers import answers
from llf_teacher.studies.report.data import read
from llf_teacher.studies.store import Store

WORDS = {YES: "Is this evidence of a difference? Yes.", NO: "evidence of a difference? No:", OPEN: "Not decided"}


@pytest.mark.parametrize("planted", STUDIES, ids=lambda each: each.name.replace(" ", "-"))
def test_the_first_sentence_is_right(tmp_path, planted):
    study = planted.made()
    records = planted.records(study)
    with Store(filled(tmp_path / "s.db", records)) as store:
        data = read(store, study)
        said = answers(data)
        for label, answer in zip(planted.labels, said, strict=False):
            compared = answer.about.compared
            assert (compared.teacher, compared.other, compared.student) == (*label.pair, label.student), answer.text
            assert answer.finding.evidence == label.evidence, answer.text
            assert WORDS[label.evidence] in answer.text
            one, other, student = map(data.called, (*label.pair, label.student))
            if label.costlier:
                way = "more" if label.costlier == label.pair[0] else "less"
                assert f"{student} loses {way} with {one} than with {other}" in answer.text
            else:
                assert not re.search(r"loses (more|less) with [^ ]+ than", answer.text)
            assert answer.about.ratio == label.ratio == ("score " in answer.text.replace("no score", ""))
            if label.mixed:
                assert "It depends on the family" in answer.text
            seeds = len({record.spec.seed for record in records})
            assert f"n = {seeds} seed" in answer.text
            regrets = [
                np.mean(
                    [r.episode.regret for r in records if (r.spec.teacher, r.spec.student) == (teacher, label.student)]
                )
                for teacher in label.pair
            ]
            if len(study.ids) == 1:
                assert f"({regrets[0]:.{digits(regrets)}f} against {regrets[1]:.{digits(regrets)}f})" in answer.text
        assert len(said) >= len(planted.labels)
        assert findings(data)[0].startswith(said[0].text[:60])


def digits(regrets):
    return 1 if max(regrets) >= 10 and abs(regrets[0] - regrets[1]) >= 0.1 else 2
