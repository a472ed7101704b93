:- module(facetlog_left_open, [ none_can_hold/4       % +Target, +Module, +Model, +Thing
                              ]).

/** <module> Where nothing can hold

A thing of which nobody knows which way is up has no level face for certain: a model that wants one is
unknown whatever faces are chosen, and thousands of choices may be equally open. The first that does
not fail then settles what the verdict is.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(variables)).

%!  none_can_hold(+Target, +Module, +Model, +Thing) is semidet.
%
%   A condition that asks for one part alone holds for nothing that the scene has. Target has the conditions'
%   specialised rules.

none_can_hold(Target, Module, Model, Thing) :-
    Target:lines(Model, Names),
    findall(line(Of, Parts, Test, Body), clause(Module:condition(Model, _, _, Of, Parts, Test), Body), Lines),
    nth1(Number, Lines, line(Of, Parts, Test, true)),
    var(Of),
    nonvar(Test),
    term_variables(Parts, PartVariables),
    term_variables(Test, TestVariables),
    include(among(TestVariables), PartVariables, [Part]),
    nth1(Number, Names, Name),
    \+ ( named(Part),
         call(Target:Name, Thing, Parts, Outlines),
         memberchk(outline(holds, _, _, _), Outlines) ),
    !.

named(Name) :- fact(face(Name)).
named(Name) :- fact(piece(Name)).
named(Name) :- fact(opening(Name)).
named(Name) :- fact(hollow_of(Name, _)).
named(Name) :- fact(edge(Name, _, _)).
named(Name) :- fact(thing(Name)).
