"""Studies that save what they have found after each part."""

from evidence.crew import AT_ONCE, in_parts


def test_results_are_saved_after_each_part_in_their_order_beside_those_that_were_there():
    saved, found = [], [-1]
    told = list(in_parts(0, "squares", lambda x: x * x, range(AT_ONCE + 2), found, lambda now: saved.append(list(now))))
    assert saved[-1] == found == [-1, *(x * x for x in range(AT_ONCE + 2))]
    assert [len(now) for now in saved] == [1, 1 + AT_ONCE, 3 + AT_ONCE]
    assert told == [f"squares: {AT_ONCE} of {AT_ONCE + 2}", f"squares: {AT_ONCE + 2} of {AT_ONCE + 2}"]


def test_with_nothing_wanted_what_was_there_is_saved():
    saved = []
    assert list(in_parts(0, "none", abs, [], [3], lambda now: saved.append(list(now)))) == []
    assert saved == [[3]]
