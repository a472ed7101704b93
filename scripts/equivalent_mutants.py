"""Mutants of mutants.py that change nothing: file, line with what is changed in ‹›, what instead;
and why nobody can tell them from the program."""

__all__ = ["EQUIVALENT"]

_BEGINS = "start_degree(Want, degree(0, 1, 0), Degree)."
_OF_ONE_PART = tuple(
    ("meaning/degrees.pl", head + goal, new)
    for head in (
        "start(not, Want, sum(none, Degree)) :- ",
        "start(if_known, Want, sum(none, Degree)) :- ",
        "start(expect(_), Want, sum(holds, Degree)) :- ",
    )
    for goal, new in (
        (_BEGINS.replace("(0,", "(‹0›,"), "1"),
        (_BEGINS.replace(" 1,", " ‹1›,"), "2"),
        (_BEGINS.replace(" 0)", " ‹0›)"), "1"),
    )
)

_BY_REASON: dict[str, tuple[tuple[str, str, str], ...]] = {
    "never read: the one part there is takes its place": _OF_ONE_PART,
    "the miss of what does not fail is 0: nothing is less for it": (
        ("meaning/degrees.pl", "(   ‹S1 == fails›", "true"),
    ),
    "whether one of the names was not seen does not depend on their order": (
        ("meaning/say.pl", "append(‹Names0, Names1›, Names).", "Names1, Names0"),
    ),
    "only rounding makes more than 1 of a membership": (
        ("meaning/fading.pl", "Degree is max(0.0, min(‹1.0›, Membership)).", "2.0"),
        ("meaning/fading.pl", "Degree is max(0.0, min(‹1.0›, FromBelow + FromAbove - 1)).", "2.0"),
    ),
    "numbers that grow are different": (
        ("batch/target.pl", "flag(facetlog_code, Number, Number + ‹1›),", "2"),
        ("batch/target.pl", ";   flag(facetlog_code, Number, Number + ‹1›),", "2"),
    ),
    "what is turned round is so either way": (
        ("batch/specialise.pl", "reverse(‹Steps0, Reversed›),", "Reversed, Steps0"),
    ),
    "a product of two has no order": (("meaning/quantities.pl", "product(‹X, Y›, V),", "Y, X"),),
    "what is in both has no order": (
        ("batch/partial.pl", "shared(‹Then1, CodeIf›, Shared),", "CodeIf, Then1"),
    ),
    "which faces are in order does not depend on which is listed first": (
        ("batch/joins.pl", "append(‹Orders1, Orders0›, Orders),", "Orders0, Orders1"),
    ),
    "no fact of a measure with several clauses stands for one value": (
        ("batch/first_answer.pl", "‹var(V1)›,", "true"),
    ),
    "what is remembered may stand before what it is remembered for": (
        ("batch/target.pl", "append(‹Inputs, [Found]›, KnownArgs),", "[Found], Inputs"),
    ),
    "a name that no other predicate has, too": (
        ("batch/target.pl", "atom_concat(‹Name, ' known'›, Known),", "' known', Name"),
        ("batch/body_code.pl", "atom_concat(‹Name, ' all'›, All),", "' all', Name"),
    ),
}

EQUIVALENT = {mutant: reason for reason, mutants in _BY_REASON.items() for mutant in mutants}
