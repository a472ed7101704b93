:- module(facetlog_thing_cases, [ thing_cases/4        % +Line, +Thing, +Context, -Cases
                                ]).

/** <module> Conditions for things of which something holds

Many a condition reads "... or this is whole". Whether a thing is whole, or any other relation of the
thing alone that is either true or false, is known before the parts are: the condition is written for
both cases, and what decides nothing in a case, and was only searched for that, falls away.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(seen_through)).
:- use_module(facetlog(vocabulary)).

%!  thing_cases(+Line, +Thing, +Context, -Cases) is det.
%
%   Line is Test-Goals. Cases is one(Line) or either(Goal, CasesIfSo, CasesIfNot).

thing_cases(Line, Thing, Context, Cases) :-
    cases(Line, Thing, Context, [], Cases).

%   A relation that is decided may still stand where simple/4 does not look: it is not decided again.
%   So a line has at most as many cases as the relations that it names allow, however it nests them.
cases(Line, Thing, Context, Decided, Cases) :-
    (   var(Thing),
        settled_of(Line, Thing, Context, Decided, Relation, Goal)
    ->  in_case(Relation, true, Line, LineIfSo),
        in_case(Relation, false, Line, LineIfNot),
        cases(LineIfSo, Thing, Context, [Relation|Decided], IfSo),
        cases(LineIfNot, Thing, Context, [Relation|Decided], IfNot),
        Cases = either(Goal, IfSo, IfNot)
    ;   Cases = one(Line)
    ).

settled_of(Line, Thing, Context, Decided, Relation, Goal) :-
    part_of_line(Line, Relation),
    compound(Relation),
    compound_name_arguments(Relation, _, [Arg]),
    Arg == Thing,
    \+ ( member(Other, Decided), Other == Relation ),
    \+ \+ known_relation(Relation),
    relation_code(Relation, Context, settled(Goal, _)),
    !.

part_of_line(Part, Part) :-
    compound(Part).
part_of_line(Line, Part) :-
    compound(Line),
    arg(_, Line, Arg),
    part_of_line(Arg, Part).

in_case(Relation, Truth, Test0-Goals0, Test-Goals) :-
    simple(Test0, Relation, Truth, Test),
    maplist(simple_goal(Relation, Truth), Goals0, Goals1),
    needed_goals(Goals1, Test, Goals).

simple_goal(_, _, Goal, Goal) :- var(Goal), !.
simple_goal(Relation, Truth, findall(X, Goal0, Xs), findall(X, Goal, Xs)) :-
    !,
    conjuncts(Goal0, Goals0),
    maplist(simple_goal(Relation, Truth), Goals0, Goals),
    conjunction(Goals, Goal).
simple_goal(Relation, Truth, possible(Test0), possible(Test)) :-
    !,
    simple(Test0, Relation, Truth, Test).
simple_goal(_, _, Goal, Goal).

%   What always succeeds once and whose result nobody asks for.
needed_goals(Goals0, Test, Goals) :-
    reverse(Goals0, Reversed),
    foldl(needed_goal, Reversed, Test-[], _-Goals).

needed_goal(Goal, Used-Goals, Next) :-
    (   result(Goal, Result),
        var(Result),
        term_variables(Used, Variables),
        \+ among(Variables, Result)
    ->  Next = Used-Goals
    ;   Next = (Used-Goal)-[Goal|Goals]
    ).

result(Goal, _) :- var(Goal), !, fail.
result(findall(_, _, Xs), Xs).
result(sort(Xs, Sorted), Sorted) :- var(Xs).
result(separate(Xs, Groups), Groups) :- var(Xs).

                 /*******************************
                 *         SIMPLE TESTS         *
                 *******************************/

%   all([]) always holds, any([]) always fails.
simple(Test, _, _, Test) :- var(Test), !.
simple(Test, Relation, Truth, Simple) :-
    Test == Relation,
    !,
    ( Truth == true -> Simple = all([]) ; Simple = any([]) ).
simple(all(Tests0), Relation, Truth, Test) :-
    is_list(Tests0),
    !,
    simple_all(Tests0, Relation, Truth, Tests1),
    exclude(==(all([])), Tests1, Tests),
    (   member(Fails, Tests), Fails == any([])
    ->  Test = any([])
    ;   Tests = [Only]
    ->  Test = Only
    ;   Test = all(Tests)
    ).
simple(any(Tests0), Relation, Truth, Test) :-
    is_list(Tests0),
    !,
    simple_all(Tests0, Relation, Truth, Tests1),
    exclude(==(any([])), Tests1, Tests),
    (   member(Holds, Tests), Holds == all([])
    ->  Test = all([])
    ;   Tests = [Only]
    ->  Test = Only
    ;   Test = any(Tests)
    ).
simple(not(Test0), Relation, Truth, Test) :-
    !,
    simple(Test0, Relation, Truth, Test1),
    (   Test1 == all([])
    ->  Test = any([])
    ;   Test1 == any([])
    ->  Test = all([])
    ;   Test = not(Test1)
    ).
simple(implies(Where0, Test0), Relation, Truth, Test) :-
    !,
    simple(Where0, Relation, Truth, Where),
    simple(Test0, Relation, Truth, Test1),
    (   ( Where == any([]) ; Test1 == all([]) )
    ->  Test = all([])
    ;   Where == all([])
    ->  Test = Test1
    ;   Test = implies(Where, Test1)
    ).
simple(if_known(Test0), Relation, Truth, Test) :-
    !,
    simple(Test0, Relation, Truth, Test1),
    ( ( Test1 == all([]) ; Test1 == any([]) ) -> Test = Test1 ; Test = if_known(Test1) ).
simple(expect(Weight, Test0), Relation, Truth, expect(Weight, Test)) :-
    !,
    simple(Test0, Relation, Truth, Test).
simple(each(X, List, Test0), Relation, Truth, Test) :-
    !,
    simple(Test0, Relation, Truth, Test1),
    ( Test1 == all([]) -> Test = Test1 ; Test = each(X, List, Test1) ).
simple(each_pair(X, Y, List, Test0), Relation, Truth, Test) :-
    !,
    simple(Test0, Relation, Truth, Test1),
    ( Test1 == all([]) -> Test = Test1 ; Test = each_pair(X, Y, List, Test1) ).
simple(some(X, List, Test0), Relation, Truth, Test) :-
    !,
    simple(Test0, Relation, Truth, Test1),
    ( Test1 == any([]) -> Test = Test1 ; Test = some(X, List, Test1) ).
simple(at_least_of(Count, X, Groups, Test0), Relation, Truth, at_least_of(Count, X, Groups, Test)) :-
    !,
    simple(Test0, Relation, Truth, Test).
simple(at_most_of(Count, X, Groups, Test0), Relation, Truth, at_most_of(Count, X, Groups, Test)) :-
    !,
    simple(Test0, Relation, Truth, Test).
simple(Test, _, _, Test).

simple_all([], _, _, []).
simple_all([Test0|Tests0], Relation, Truth, [Test|Tests]) :-
    simple(Test0, Relation, Truth, Test),
    simple_all(Tests0, Relation, Truth, Tests).
