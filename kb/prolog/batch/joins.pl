:- module(facetlog_joins, [ chosen_once/2         % +Body, -Body
                          ]).

/** <module> Faces of a join, chosen once

A body that proposes several faces goes through those of the thing in loops within loops:

    face_of(Thing, A), possible(TestA), face_of(Thing, B), A @< B, possible(TestB), ...

What is asked of an inner face alone is asked again for each face of the loops around it. It is asked of
all faces before instead, once for the thing.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(target)).

%!  chosen_once(+Body0, -Body) is det.
%
%   Body has chosen(Thing, X, Goals) for each generator face_of(Thing, X) within another: X is one of the
%   faces for which Goals succeed. Its answers are those of Body0, in their order.

chosen_once(Body0, Body) :-
    conjuncts(Body0, Goals0),
    (   append(First, [Goal|Inner0], Goals0),
        generator(Goal, _, _)
    ->  inner(Inner0, Inner),
        append(First, [Goal|Inner], Goals),
        conjunction(Goals, Body)
    ;   Body = Body0
    ).

generator(Goal, Thing, X) :-
    nonvar(Goal),
    Goal = face_of(Thing, X),
    var(Thing),
    var(X).

inner([], []).
inner([Goal|Goals0], Inner) :-
    (   generator(Goal, Thing, X),
        asked_alone(Goals0, [Thing, X], Tests, Goals),
        Tests \== []
    ->  maplist(possible_goal, Tests, Possible),
        Inner = [chosen(Thing, X, [Goal|Possible])|Inner1],
        inner(Goals, Inner1)
    ;   Inner = [Goal|Inner1],
        inner(Goals0, Inner1)
    ).

possible_goal(Test, possible(Test)).

%   Tests of Goals0 ask for nothing but Known; Goals are what is left.
asked_alone([], _, [], []).
asked_alone([Goal0|Goals0], Known, Tests, Goals) :-
    (   nonvar(Goal0),
        Goal0 = possible(Test),
        nonvar(Test)
    ->  ( Test = all(Parts), is_list(Parts) -> true ; Parts = [Test] ),
        partition(asks_only(Known), Parts, Alone, Others),
        ( Others == [] -> Goals = Goals1 ; Goals = [possible(all(Others))|Goals1] ),
        append(Alone, Tests1, Tests)
    ;   Goals = [Goal0|Goals1],
        Tests = Tests1
    ),
    asked_alone(Goals0, Known, Tests1, Goals1).

asks_only(Known, Test) :-
    term_variables(Test, Variables),
    Known = [_, X],
    among(Variables, X),
    \+ ( member(Variable, Variables), \+ among(Known, Variable) ).
