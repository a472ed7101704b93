:- module(facetlog_joins, [ by_pairs/2            % +Body, -Body
                          ]).

/** <module> Faces of a join, by pairs

A body that proposes several faces goes through those of the thing in loops within loops:

    face_of(Thing, A), possible(TestA), face_of(Thing, B), A @< B, possible(TestB), ...

A test of an inner face alone would run again for each face of the loops around it, and a test of
two faces for each of the loops around or between them. So which faces pass alone is found once for
the thing, and which pass with another one once for that; where roles ask the same of their faces, as those
of a box do, once for all of them. The innermost loop goes through the faces that pass with the one chosen
last, and looks them up in the lists of the others.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(target)).

%!  by_pairs(+Body0, -Body) is det.
%
%   Body has chosen(Inputs, X, Goals) in the place of face_of(Thing, X) within another, and
%   among_chosen(Inputs, X, Goals) in that of tests: X is one of the faces for which Goals succeed, and which
%   these are follows from Inputs, the thing and perhaps another face. Its answers are those of Body0, in
%   their order.

by_pairs(Body0, Body) :-
    conjuncts(Body0, Goals0),
    joined(Goals0, [], [], Goals),
    conjunction(Goals, Body).

%   joined(Goals0, Outer, Orders, Goals): Outer are the faces chosen so far, the last first; Orders has A-B
%   for each two of them that must be in that order.
joined([], _, _, []).
joined([Goal|Goals0], Outer, Orders0, Goals) :-
    (   generator(Goal, Thing, X)
    ->  orders(Goals0, X, Orders0, Orders1),
        append(Orders1, Orders0, Orders),
        (   Outer == []
        ->  Goals = [Goal|Inner],
            Goals2 = Goals0
        ;   taken(Goals0, [X, Thing], Alone, Goals1),
            chosen([Thing], X, Goal, Alone, Own),
            foldl(with_other(Thing, X, Own, Orders1), Outer, Goals1-[], Goals2-Sets),
            all_sets(Sets, Own, Goals, Inner)
        ),
        joined(Goals2, [X|Outer], Orders, Inner)
    ;   Goals = [Goal|Inner],
        joined(Goals0, Outer, Orders0, Inner)
    ).

generator(Goal, Thing, X) :-
    nonvar(Goal),
    memberchk(Goal, [face_of(Thing, X), piece_in(Thing, X), opening_through(Thing, X), hollow_in(Thing, X)]),
    !,
    var(Thing),
    var(X).

%   Which of the faces before must come before X: A @< B and B @< X say so of A as well.
orders(Goals, X, Orders0, Orders) :-
    (   member(Goal, Goals),
        Goal = (Last0 @< X0),
        X0 == X,
        var(Last0)
    ->  findall(true-Number, ( nth1(Number, Orders0, _-B), B == Last0 ), Numbers),
        maplist(before(Orders0, X), Numbers, Earlier),
        Orders = [Last0-X|Earlier]
    ;   Orders = []
    ).

before(Orders, X, true-Number, A-X) :- nth1(Number, Orders, A-_).

with_other(Thing, X, Own, Orders, Other, Goals0-Sets, Goals-Sets1) :-
    taken(Goals0, [X, Other, Thing], Tests, Goals1),
    (   member(A-_, Orders),
        A == Other
    ->  exclude(==(Other @< X), Goals1, Goals),
        Order = [Other @< X]
    ;   Goals = Goals1,
        Order = []
    ),
    (   Order == [],
        Tests == []
    ->  Sets1 = Sets
    ;   append([Own|Order], Tests, Both),
        append(Sets, [chosen([Thing, Other], X, Both)], Sets1)
    ).

all_sets([], Own, [Own|Inner], Inner).
all_sets([Set|Sets], _, [Set|Goals], Inner) :-
    maplist(looked_up, Sets, Tests),
    append(Tests, Inner, Goals).

looked_up(chosen(Inputs, X, Goals), among_chosen(Inputs, X, Goals)).

chosen(_, _, Goal, [], Goal) :- !.
chosen(Inputs, X, Goal, Tests, chosen(Inputs, X, [Goal|Tests])).

%   Tests, which ask for the first of Known, and nothing but Known; Goals are what is left.
taken([], _, [], []).
taken([Goal0|Goals0], Known, Tests, Goals) :-
    (   nonvar(Goal0),
        Goal0 = possible(Test),
        nonvar(Test)
    ->  ( Test = all(Parts), is_list(Parts) -> true ; Parts = [Test] ),
        partition(asks_only(Known), Parts, Only, Others),
        ( Others == [] -> Goals = Goals1 ; Goals = [possible(all(Others))|Goals1] ),
        maplist(possible_goal, Only, Possible),
        append(Possible, Tests1, Tests)
    ;   Goals = [Goal0|Goals1],
        Tests = Tests1
    ),
    taken(Goals0, Known, Tests1, Goals1).

possible_goal(Test, possible(Test)).

asks_only(Known, Test) :-
    term_variables(Test, Variables),
    Known = [X|_],
    among(Variables, X),
    \+ ( member(Variable, Variables), \+ among(Known, Variable) ).
