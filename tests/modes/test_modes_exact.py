"""Contact modes against exact rational arithmetic: both give the same set of consistent words."""

import pytest
import standfast as sf
from modes_problems import all_cases


@pytest.mark.parametrize("method", ["auto", "enumerate"])
def test_consistent_words_are_those_of_exact_arithmetic(method):
    wrong = []
    for case in all_cases():
        modes = sf.contact_modes(sf.ContactProblem(**case.keywords), method=method)
        if set(modes.consistent) != case.words:
            wrong.append((case.name, sorted(case.words), modes.consistent))
    assert len(all_cases()) >= 400
    assert not wrong


def test_programmes_return_consistent_words_only():
    solvable = found = 0
    for case in all_cases():
        modes = sf.contact_modes(sf.ContactProblem(**case.keywords), method="qp")
        assert set(modes.consistent) <= case.words, case.name
        solvable += bool(case.words)
        found += bool(modes.consistent)
    print(f"found a mode in {found} of {solvable} solvable problems")
    assert found >= 0.99 * solvable


def test_sixty_four_legs():
    n = 64
    legs = [(2 * i / (n - 1) - 1, -1) for i in range(n)]
    table = sf.ContactProblem(
        mass=2,
        gyration_radius=0.5,
        arms=legs,
        tangents=[(1, 0)] * n,
        friction=[0.5] * n,
        sliding=[0] * n,
        bias=[(0, 0)] * n,
        free_acceleration=(0, -10, 0),
    )
    modes = sf.contact_modes(table)
    assert modes.consistent == ["F" * n]
    rest = modes["F" * n]
    assert rest.forces[:, 1].sum() == pytest.approx(20)
    assert rest.determined == "family"
    assert sf.contact_modes(table, method="qp").consistent == ["F" * n]
