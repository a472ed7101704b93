:- module(facetlog_spelling, [ nearest/3,     % +Name, +Names, -Nearest
                               hint/3         % +Name, +Names, -Hint
                             ]).

/** <module> What a misspelt word was meant to be */

:- use_module(library(lists)).
:- use_module(library(apply)).

%!  nearest(+Name, +Names, -Nearest) is semidet.
%
%   Nearest is that of Names from which the fewest letters must be changed, dropped, added or
%   exchanged with their neighbour to give Name, and of those the one that begins most alike; not if
%   so many must that it is another word.

nearest(Name, Names, Nearest) :-
    atom_codes(Name, Codes),
    length(Codes, Length),
    Most is min(3, (Length + 1)//3),    % one slip in three letters, three at most
    findall(key(Distance, Unlike)-Known,
            ( member(Known, Names),
              Known \== Name,
              spelt_with_letters(Known),
              atom_codes(Known, KnownCodes),
              length(KnownCodes, KnownLength),
              abs(KnownLength - Length) =< Most,
              distance(Codes, KnownCodes, Distance),
              Distance =< Most,
              beginning(Codes, KnownCodes, 0, Alike),
              Unlike is -Alike ),
            Found),
    keysort(Found, [_-Nearest|_]).

%   Nobody misspells an operator.
spelt_with_letters(Name) :-
    sub_atom(Name, 0, 1, _, First),
    char_type(First, csymf).

beginning([Code|Codes], [Code|Others], Alike0, Alike) :-
    !,
    Alike1 is Alike0 + 1,
    beginning(Codes, Others, Alike1, Alike).
beginning(_, _, Alike, Alike).

%!  hint(+Name, +Names, -Hint) is det.
%
%   Hint is "; did you mean ...?" or nothing.

hint(Name, Names, Hint) :-
    (   nearest(Name, Names, Nearest)
    ->  format(string(Hint), "; did you mean ~w?", [Nearest])
    ;   Hint = ""
    ).

%!  distance(+Codes, +Others, -Distance) is det.
%
%   Distance of Damerau and Levenshtein, neighbours exchanged at most once, row by row.

distance(Codes, Others, Distance) :-
    length(Others, Length),
    numlist(0, Length, Row),
    rows(Codes, none, none, Row, Others, Distance).

rows([], _, _, Row, _, Distance) :-
    last(Row, Distance).
rows([Code|Codes], Last, Before, Row, Others, Distance) :-
    Row = [First|_],
    Next is First + 1,
    cells(Others, none, Row, shifted(Before), Code, Last, Next, Cells),
    rows(Codes, Code, Row, [Next|Cells], Others, Distance).

%   Row is the row above from the cell left above on, Shifted the one above it from one cell before
%   that on.
cells([], _, _, _, _, _, _, []).
cells([Other|Others], LastOther, [Diagonal,Above|Row], Shifted, Code, Last, Left, [Cell|Cells]) :-
    ( Code == Other -> Change = Diagonal ; Change is Diagonal + 1 ),
    Cell0 is min(Change, min(Above, Left) + 1),
    (   Code == LastOther,
        Last == Other,
        Shifted = cells([Corner|_])
    ->  Cell is min(Cell0, Corner + 1)
    ;   Cell = Cell0
    ),
    shift(Shifted, Shifted1),
    cells(Others, Other, [Above|Row], Shifted1, Code, Last, Cell, Cells).

shift(shifted(none), shifted(none)).
shift(shifted([Cell|Cells]), cells([Cell|Cells])).
shift(cells([_|Cells]), cells(Cells)).
