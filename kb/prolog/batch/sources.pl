:- module(facetlog_sources, [ written_body/3,       % +Module, +Body, -Goals
                              sources/2,            % +Goals, -Steps
                              scope/4,              % +Thing, +Parts, +Goals, -Scope
                              step_code/4,          % +Scope, +Context, +Step, -Code
                              without/3             % +Excluded, +Names, -Others
                            ]).

/** <module> What quantifiers go through

A condition on "each face other where ..." has its faces found by its body:

    findall(X, ( face_of(Thing, X), \+ memberchk(X, Parts), possible(Test) ), Found),
    sort(Found, Xs)

Who these are but for the parts themselves depends on few of the parts, if on any: they are found once
for those.

A source is source(X, Goals, Excluded, Test, Xs), where Goals are those without the exclusion and the
test, and Test is all([]) if there is none. A scope is scope(Thing, Parts, Derived): the variables for
the thing and its parts, and those that a body binds.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(body_code)).

%!  written_body(+Module, +Body, -Goals) is det.
%
%   Goals are those of Body, with the bodies of what only collects faces in its place.

written_body(Module, Body, Goals) :-
    conjuncts(Body, Goals0),
    maplist(written_goals(Module), Goals0, Lists),
    append(Lists, Goals).

written_goals(Module, Goal, Goals) :-
    (   callable(Goal),
        Goal \= _:_,
        current_predicate(_, Module:Goal),
        \+ predicate_property(Module:Goal, imported_from(_)),
        predicate_property(Module:Goal, number_of_clauses(_)),
        findall(Goal-Body0, clause(Module:Goal, Body0), [Alike-Body]),
        Alike =@= Goal,
        conjuncts(Body, [findall(_, _, Found), sort(Same, _)]),
        Same == Found
    ->  Alike = Goal,
        conjuncts(Body, Goals)
    ;   Goals = [Goal]
    ).

%!  sources(+Goals, -Steps) is det.
%
%   Steps are sources, and the other goals as they are.

sources([], []).
sources([findall(X, Goal, Found), sort(Same, Xs)|Goals], [Source|Steps]) :-
    Same == Found,
    var(Xs),
    var(X),
    source(X, Goal, Xs, Source),
    !,
    sources(Goals, Steps).
sources([Goal|Goals], [Goal|Steps]) :-
    sources(Goals, Steps).

source(X, Goal, Xs, source(X, Goals, Excluded, Test, Xs)) :-
    conjuncts(Goal, Goals0),
    (   append(Goals1, [possible(Test)], Goals0)
    ->  true
    ;   Goals1 = Goals0,
        Test = all([])
    ),
    nonvar(Test),
    select(\+ memberchk(X0, Excluded), Goals1, Goals),
    !,
    X0 == X,
    is_list(Excluded),
    \+ ( member(Other, Goals), \+ plain(Other) ).

plain(Goal) :- callable(Goal), \+ Goal = (\+ _), Goal \== !.

%!  scope(+Thing, +Parts, +Goals, -Scope) is det.

scope(Thing, Parts, Goals, scope(Thing, PartVariables, Derived)) :-
    term_variables(Thing-Parts, Given),
    term_variables(Parts, PartVariables),
    term_variables(Goals, All),
    exclude(among(Given), All, Derived).

%!  inputs(+Term, +Scope, -Inputs) is det.
%
%   The variables of the scope that stand in Term.

inputs(Term, scope(Thing, Parts, Derived), Inputs) :-
    term_variables(Term, Variables),
    append([Thing|Parts], Derived, All),
    include(among(Variables), All, Inputs).

%!  few_inputs(+Term, +Scope, -Inputs) is semidet.
%
%   Term depends on the thing and not on all parts: the same answer is wanted again for the same inputs.

few_inputs(Term, Scope, Inputs) :-
    Scope = scope(Thing, Parts, Derived),
    term_variables(Term, Variables),
    \+ ( member(Variable, Derived), among(Variables, Variable) ),
    inputs(Term, Scope, Inputs),
    exclude(==(Thing), Inputs, Used),
    length(Used, Count),
    length(Parts, All),
    ( Count < All -> true ; All =:= 0 ).

%!  source_code(+Source, +Scope, +Context, -Code) is det.
%
%   Code finds Xs.

source_code(Source, Scope, Context, Code) :-
    Source = source(X, Goals, Excluded, Test, Xs),
    Context = context(Module, _, _),
    (   own_inputs(Source, Scope, Inputs)
    ->  ( Test == all([]) -> Searched = Goals ; append(Goals, [possible(Test)], Searched) ),
        listed_code(sorted, Inputs, X, Searched, Module, Context, All, AllCode),
        Code = ( AllCode, facetlog_sources:without(Excluded, All, Xs) )
    ;   conjunction(Goals, Goal),
        body_code(Module:( findall(X, ( Goal, \+ memberchk(X, Excluded), possible(Test) ), Found),
                           sort(Found, Xs) ), Context, Code)
    ).

%!  step_code(+Scope, +Context, +Step, -Code) is det.
%
%   Of a source or any other goal of a body.

step_code(Scope, Context, Step, Code) :-
    (   nonvar(Step),
        Step = source(_, _, _, _, _)
    ->  source_code(Step, Scope, Context, Code)
    ;   Context = context(Module, _, _),
        body_code(Module:Step, Context, Code)
    ).

%   The variable of the source and what is local to its goals are no inputs.
own_inputs(source(X, Goals, _, Test, _), scope(Thing, Parts, Derived0), Inputs) :-
    term_variables(X-Goals, Own),
    exclude(among(Own), Derived0, Derived),
    few_inputs(Goals-Test, scope(Thing, Parts, Derived), Inputs).

%!  without(+Excluded, +Names, -Others) is det.

without([], Names, Names).
without([Name|Excluded], Names0, Names) :-
    (   memberchk(Name, Names0)
    ->  left_out(Names0, Name, Names1)
    ;   Names1 = Names0
    ),
    without(Excluded, Names1, Names).

left_out([Name|Names], Name0, Others) :-
    (   Name == Name0
    ->  Others = Names
    ;   Others = [Name|Others1],
        left_out(Names, Name0, Others1)
    ).
