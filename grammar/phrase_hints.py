"""Hints for phrases that people write first and that the language puts otherwise."""

import re
from collections.abc import Mapping
from types import MappingProxyType

_BY_SPACE = (
    "a model means the same however a thing was measured: write what must be full or free "
    "(`solidity(this)`, `hollow_side(this)`, `free_below(top)`), and `if known:` before what need "
    "not be known"
)
_HOW_MUCH = (
    "say how much: `length(top) at least 40 cm`, or as a share, `width(top) at most 50 % of "
    "length(top)`"
)
_ON_GROUND = "write `leg is on_ground`"
_FREE_BELOW = (
    "write `free_below(top) at least 60 %`, or how high, `room_below(top) at least 40 cm`; above "
    "it `room_above(top) at least 40 cm`"
)
_SHELVES = "write `shelves_below(top) at least 2`"
_HANGS = "write `lamp hangs_from beam`"
_GAP = (
    "name what one sees through: `opening way`; of two things say `gap(table, seat) at most 10 cm`"
)
_OPEN = (
    "write `hollow_side(this) at least 60 %`, beneath a top `open_from_two_sides(top) at least "
    "30 %`, or name what is open: `opening way` through it, `hollow inner where inner is "
    "open_at_top` within it"
)
_HOLLOW = "name it: `hollow shaft where shaft is open_at_top`, or `open_at_side`"
_CLOSED = (
    "write `closed_behind(seat) at least 70 %` of one side, of the whole rim `enclosed(floor) at "
    "least 85 %`"
)
_SET_BACK = (
    "write `piece plinth where plinth is on_ground`, `plinth carries body` and "
    "`inset(plinth, body) at least 2 cm`"
)
_WHEEL = (
    "write `piece wheel where curved(wheel) at least 80 %, wheel is upright`: round, with a level "
    "axis; then `wheel is on_ground`, or `axle joins wheel`"
)
_CORNERS = (
    "write `corner_inset(leg, top) at most 15 % of width(top)`: near two sides of it; the corners "
    "of a face's outline are counted, `corners(face) = 4`"
)
_DECK = (
    "boards at one height are one level: name any of them, `board slat`, and write `cover(slat) at "
    "least 60 %`"
)
_EVEN = (
    "write `smallest step of elevation(rung) at least 80 % of largest step of elevation(rung)`: "
    "steps are the differences of neighbours; seen from above `smallest spacing of post at least "
    "80 % of largest spacing of post`"
)
ORDER = (
    "write `order of length(key) at least 90 %`: along the row that they stand in, seen from "
    "above; of what stands over one another `each pair x, y of step: x is not above y or "
    "length(x) at most length(y)`"
)
_OUTLINE = "count the corners of a face's outline: `corners(top) = 6`"
_ENCLOSED = "write `enclosed(floor) at least 85 %`"

_SQUARE = "write `angle(a, b) = 90 deg ± 10 deg`"
_ALONG = "write `parallel(a, b, 10 deg)`"
_TILTED = "say how much: `tilt(leg) between 60 deg and 85 deg`; 0 is level, 90 upright"
_LIES = "write `a is level`, or `b carries a` of what lies on another"
_STANDS = "write `a is upright`, `a is on_ground`, or `b carries a`"
_TOUCH = "write `a joins b` of pieces, `a adjoins b` of faces"
_CENTRED = (
    "write `distance(a, b) at most 10 % of width(b)`: seen from above, how far apart their middles "
    "are"
)
_SYMMETRIC = "say what is alike on both sides: `inset(left, seat) about inset(right, seat)`"
_SAME = (
    "compare measures: `length(a) about length(b)`; of a set `lowest of length(x) at least 95 % of "
    "highest of length(x)`"
)

SPOKEN_WORDS: Mapping[str, str] = MappingProxyType(
    {
        "whole": _BY_SPACE,
        "scanned": _BY_SPACE,
        "horizontal": "write `level`",
        "flat": "write `level`, or `board` for what is thin",
        "vertical": "write `upright`",
        "thin": "call it a `board`, or write `thickness(top) at most 3 cm`",
        "slender": "call it a `bar`, or write `width(leg) at most 10 % of length(leg)`",
        "seen": "write `measured`: not only completed from what is round it",
        "visible": "write `measured`: not only completed from what is round it",
        **dict.fromkeys(
            ("perpendicular", "orthogonal", "crosswise", "crossways", "crosses", "across"), _SQUARE
        ),
        **dict.fromkeys(("lengthwise", "lengthways", "aligned", "along"), _ALONG),
        **dict.fromkeys(
            (
                "tilted",
                "leaning",
                "leans",
                "sloping",
                "slopes",
                "sloped",
                "slanted",
                "slanting",
                "inclined",
                "splayed",
                "oblique",
                "diagonal",
            ),
            _TILTED,
        ),
        **dict.fromkeys(("lying", "lies"), _LIES),
        "stands": _STANDS,
        **dict.fromkeys(("touching", "touch", "meets", "contacts"), _TOUCH),
        **dict.fromkeys(("centred", "centered", "central", "centre", "middle"), _CENTRED),
        **dict.fromkeys(("symmetric", "symmetrical", "mirrored"), _SYMMETRIC),
        **dict.fromkeys(("equal", "equals", "same", "same_size", "identical", "alike"), _SAME),
        "ground": _ON_GROUND,
        "floor": _ON_GROUND,
        "stands_on": _ON_GROUND,
        "standing": _ON_GROUND,
        "touches": "write `a joins b` of pieces, `a adjoins b` of faces",
        "supports": "write `leg carries top`",
        "round": "write `curved(top) at least 80 %`: what is round is curved all round its axis",
        **dict.fromkeys(("wheel", "wheels", "castor", "disc"), _WHEEL),
        **dict.fromkeys(("set_back", "recessed", "plinth"), _SET_BACK),
        **dict.fromkeys(("deck", "slat", "slats", "plank", "planks"), _DECK),
        **dict.fromkeys(("corner", "at_corner"), _CORNERS),
        **dict.fromkeys(
            ("hollow", "recess", "cavity", "shaft", "basin", "compartment", "inner", "inside_of"),
            _HOLLOW,
        ),
        "outline": _OUTLINE,
        **dict.fromkeys(("evenly", "evenly_spaced", "equidistant", "regular", "spacing"), _EVEN),
        **dict.fromkeys(("sorted", "ordered", "order", "ascending", "descending"), ORDER),
        "square": "write `width(top) at least 90 % of length(top)`",
        "open": _OPEN,
        "closed": _CLOSED,
        "enclosed": _ENCLOSED,
        "surrounded": _ENCLOSED,
        **dict.fromkeys(("space", "room", "clearance", "free"), _FREE_BELOW),
        "shelves": _SHELVES,
        "gap": _GAP,
        "nothing": "write `there is no piece x where x above top`",
        "overlaps": "write how much of the smaller: `overlap(top, seat) at least 10 %`",
        **dict.fromkeys(
            (
                "big",
                "large",
                "small",
                "long",
                "short",
                "wide",
                "narrow",
                "high",
                "tall",
                "low",
                "deep",
                "thick",
            ),
            _HOW_MUCH,
        ),
        **dict.fromkeys(
            ("opening", "hole"), "name it: `opening way`, and `way in front` for where it is"
        ),
    }
)
"""Words that say nothing by themselves, or are none of the language, and what to write instead."""


_NAME_PIECES = "name pieces: `board top`, `bar leg`"

_OF_FACES: Mapping[str, str] = MappingProxyType(
    {
        "joins": f"of faces say `a adjoins b`, or {_NAME_PIECES}",
        "carries": f"of faces say `leg supports top`, or {_NAME_PIECES}",
        "hangs_from": _NAME_PIECES,
        "beside": f"of faces say `overlap(a, b) at most 10 %`, or {_NAME_PIECES}",
        "inside": _NAME_PIECES,
        "thickness": _NAME_PIECES,
        "touches": "of faces say `a adjoins b`, of pieces `a joins b`",
    }
)
_OF_PIECES: Mapping[str, str] = MappingProxyType(
    {
        "adjoins": "of pieces say `a joins b`",
        "supports": "of pieces say `leg carries top`",
        "touches": "of pieces say `a joins b`",
        "gap": "of pieces say `a joins b`: they touch",
        "corners": _CORNERS,
    }
)


def find_word_of_other_kind(word: str, kind: str) -> str:
    """Return a hint for a word that does not apply to `a face` or `a piece`; may be empty.

    >>> find_word_of_other_kind("gap", "a piece")
    'of pieces say `a joins b`: they touch'
    """
    return {"a face": _OF_FACES, "a piece": _OF_PIECES}.get(kind, {}).get(word, "")


# Words that begin a statement of the language, and ones that stand within one.
_FIRST_WORDS = (
    "use|model|let|define|drop|size|example|expect|optional|one|at|exactly|between|any|each|there"
    "|not|no|if|face|edge|vertex|element|piece|board|bar|block|opening|hollow"
)
_WITHIN = "is|are|at|of|has|not|where|and|or|between|about|holds|fails|unknown|like|rather"

# Phrases as people say them, and what to write; `{…}` stands for the pattern's groups. In the order
# in which they are tried: what says most comes first.
_AMOUNT = r"[\d.]+(?:\s*(?:%|°|\w+))?"
_PHRASES = (
    (
        rf"\b(?:(?:is|are)\s+)?(?:from\s+|between\s+|at\s+least\s+)?(?P<low>{_AMOUNT})"
        rf"\s*(?:to\b|–|-(?=\d)|and\s+at\s+most\b)\s*(?P<high>{_AMOUNT})"
        r"(?P<of>(?:\s+of\s+\w+(?:\([^()]*\))?)?)",
        "write `between {low} and {high}{of}`",
    ),
    (
        r"\b(?:is|are)\s+(?P<how>at\s+(?:least|most)|between|about)\b\s*",
        "write `{how}` without `is`",
    ),
    (r"\bstands?\s+on\b.*", _ON_GROUND),
    (r"\bparallel\s+to\b.*", "write `parallel(back, front, 10 deg)`"),
    (
        r"\b(?:perpendicular|square|at\s+right\s+angles)\s+to\b.*",
        "write `angle(back, seat) = 90 deg ± 10 deg`",
    ),
    (r"\b(?:across\s+\w+|cross(?:wise|ways)\b.*)", _SQUARE),
    (r"\blength(?:wise|ways)\b.*", _ALONG),
    (r"\b(?:leans?|leaning)\s+(?:on|against|over)\b.*", f"{_TILTED}; and `leg joins top`"),
    (r"\b(?:centred|centered|(?:in|at)\s+the\s+(?:middle|centre|center))\b.*", _CENTRED),
    (r"\b(?:aligned|in\s+line)\s+with\b.*", _ALONG),
    (r"\b(?:equal|identical|same)\b.*", _SAME),
    (r"\bon\s+top\s+of\b.*", "write `back above seat`, or `seat carries back`"),
    (
        r".*\b(?:(?:sorted|ordered)\s+(?:by|along)|than\s+the\s+(?:one|last|next|previous)"
        r"|(?P<more>\w+er)\s+and\s+(?P=more))\b.*",
        ORDER,
    ),
    (
        r"\b(?:high|tall|wid|long|low|thick|small|larg|bigg?|deep)er\s+than\b.*",
        "compare measures: `length(top) at least 120 % of length(seat)`",
    ),
    (r"\b(?:hang(?:s|ing)?|hung|suspended)\s+(?:from|on|under|below)\b.*", _HANGS),
    (r"\b(?:rest|lie|sit)s?\s+on\b.*", "write `leg carries top`"),
    (r"\bis\s+(?:inside|within)\s+\w+", "write `lamp inside way`"),
    (r".*\bshelves\s+(?:below|under|beneath|underneath)\b.*", _SHELVES),
    (
        r"\b(?:space|room|clearance|height)\s+(?:below|under|beneath|underneath|above)\b.*",
        _FREE_BELOW,
    ),
    (r"\b(?:space|room|gap|distance)\s+between\b.*", _GAP),
    (r"\bopen\s+(?:from|on|at|to|in|below|beneath|under)\b.*", _OPEN),
    (r"\bclosed\s+(?:at|on|in|behind|from|round|all)\b.*", _CLOSED),
    (r"\bnext\s+to\b.*", "write `left beside right`, or `left joins right`"),
    (
        r"\b(?:attached|connected|fastened|fixed|joined)\s+(?:to|with)\b.*",
        "write `back joins seat`",
    ),
    (r"\b(?:under|underneath|beneath)\s+\w+", "write `shelf below top`"),
    (r"\b(?:is|are)\s+(?:set\s+back|recessed|inset)\b.*", _SET_BACK),
    (r"\b(?:evenly|equally|regularly)\s+(?:spaced|apart)\b.*", _EVEN),
    (r"\bmade\s+(?:up\s+)?of\s+(?:boards|slats|planks)\b.*", _DECK),
    (r"\bcorners\s+of\s+(?:the|an|its)\s+outline\b.*", _OUTLINE),
    (r"\b(?:at\s+)?(?:(?:the|each|every)\s+)*corners?\s+of\b.*", _CORNERS),
    (r"\b(?:is|are)\s+an?\s+(?P<name>\w+)", "leave the article out: `is {name}`"),
    (r"\bis\s+over\s+\w+", "write `back above seat`"),
    (r"\bfac(?:es|ing)\s+up\w*", "write `upward`"),
    (r"\bfac(?:es|ing)\s+down\w*", "write `downward`"),
    (
        r"^(?:(?:all|every)\s+(?:of\s+)?(?:the\s+)?\w+\s+(?:is|are|has|have)"
        r"|the\s+\w+s\s+are)\b.*",
        "write `each`, a colon, and the set's name again: `each leg: leg is ...`",
    ),
    (r"\bnothing\s+(?P<where>\w+).*", "write `there is no piece x where x {where} ...`"),
    (
        r"\b(?P<name>\w+)\s+has\s+an?\s+(?:opening|hole|gap)\b.*",
        "name it: `opening way`, and `way in {name}`",
    ),
    (
        r"\b(?P<name>\w+)\s+is\s+(?P<size>[\d.]+\s*\w+)\s+(?:wide|long|high|tall|thick|deep)",
        "write `width({name}) about {size}`, or `length`, `height`, `thickness`",
    ),
    (r"\)\s+is\s+(?P<size>[\d.]+\s*\w*).*", "write `about {size}`"),
    (
        r"^(?:(?:at\s+(?:least|most)|exactly)\s+one|(?:at\s+(?:least|most)\s+|exactly\s+)?"
        r"(?:two|three|four|five|six|seven|eight|nine|ten))\s+(?P<kind>\w+)\b.*",
        "write the number in digits: `exactly 4 {kind} ...`",
    ),
    (r"~", "write `about`"),
    (r">=?", "write `at least`"),
    (r"<=?", "write `at most`"),
    (
        r"^(?:at\s+(?:least|most)|exactly)\s+(?P<count>\d+)\s+(?P<name>\w+)\s+where\b\s*\w*",
        "say of what kind they are: `at least {count} bars {name} where ...`",
    ),
    (
        r"^(?P<count>\d+)\s+(?P<kind>\w+)\s+\w+",
        "write `exactly {count} {kind} ...` or `at least {count} {kind} ...`",
    ),
    (
        r"^(?P<kind>\w+s)\s+(?P<name>\w+)\s+where\b.*",
        "say how many: `any number of {kind} {name} where ...`, or `at least 2 {kind} ...`",
    ),
    (
        r"^there\s+(?P<what>is\s+(?:an?|no)\s+\w+|are\s+.*?\w+)\s+(?P<where>above|below|on|in)\s.*",
        "give it a name: `there {what} x where x {where} ...`",
    ),
    (
        r"^no\s+(?P<kind>\w+)\s+(?P<where>\w+).*",
        "write `there is no {kind} x where x {where} ...`",
    ),
    (
        r"\b(?P<measure>length|width|height|thickness|elevation|tilt|solidity)\s+of\s+(?P<name>\w+)"
        r"(?:\s+\w+)?",
        "write `{measure}({name})`",
    ),
    (
        r"\b(?P<name>\w+)\s+has\s+(?:an?\s+)?(?P<measure>\w+)(?:\s+of)?\s+(?P<size>[\d.]+\s*\w*).*",
        "write `{measure}({name}) about {size}`",
    ),
    (
        rf"^(?!(?:{_FIRST_WORDS})\b)\w+\s+(?!(?:{_WITHIN})\b)(?P<name>\w+)$",
        "a part is a `face`, a `board`, a `bar`, a `block`, a `piece`, an `opening` or a `hollow`: "
        "`board {name}`",
    ),
    (r"\bthe\s+(?P<name>\w+)(?:\s+\w+){0,2}", "leave the article out: `{name}`"),
)


def find_phrase_hint(text: str, at: int) -> str:
    """Return a hint for the phrase at which a statement cannot be read.

    `at` is the offset of the sign that cannot be read, or the text's end; empty where none of the
    phrases that people say goes over it.
    """
    for said, write in _PHRASES:
        for match in re.finditer(said, text):
            if match.start() <= at <= match.end():
                return write.format(**match.groupdict())
    return ""
