:- module(facetlog_line_code, [ line_code/6,          % +Mode, +Context, +Model, +Number, +Line, -Name
                               first_code/4          % +Context, +Line, +Name, -First
                             ]).

/** <module> Conditions of models into goals

A line is line(Label, Thing, Parts, Test, Body), a clause of condition/6 of the rules. What it says is
written for each case of the thing (thing_cases.pl), with what quantifiers go through found once
(sources.pl); and what then does not depend on all parts is asked once for those that it depends on.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(state_code)).
:- use_module(facetlog_kb(outline_code)).
:- use_module(facetlog_kb(seen_through)).
:- use_module(facetlog_kb(thing_cases)).
:- use_module(facetlog_kb(sources)).

%!  line_code(+Mode, +Context, +Model, +Number, +Line, -Name) is det.
%
%   Name(Thing, Parts, Outlines) gives the outlines of Line, which has one or several as Number says;
%   Mode as in outline_code.pl.

line_code(Mode, Context, Model, Number, line(Label, Thing, Parts, Test, Body0), Name) :-
    helper(Context, line(Model, Label, Mode, Test, Body0), [Thing, Parts, Outlines], Head, true),
    functor(Head, Name, _),
    cases_of(Context, Thing, Test, Body0, Cases),
    case_code(Cases, leaf(Mode, Number, Thing-Parts, Context, Head), Outlines, Code),
    put_clause(Context, (Head :- Code, !)),
    (   Thing-Parts =@= _-_
    ->  true
    ;   functor(Other, Name, 3),
        arg(3, Other, []),
        put_clause(Context, Other)
    ).

cases_of(Context, Thing, Test, Body, Cases) :-
    Context = context(Module, _, _),
    written_body(Module, Body, Goals),
    thing_cases(Test-Goals, Thing, Context, Cases).

case_code(either(Goal, IfSo, IfNot), Leaf, Outlines, ( Goal -> CodeIfSo ; CodeIfNot )) :-
    case_code(IfSo, Leaf, Outlines, CodeIfSo),
    case_code(IfNot, Leaf, Outlines, CodeIfNot).
case_code(one(Test-Goals), leaf(Mode, Number, Thing-Parts, Context, Head), Outlines, Code) :-
    scope(Thing, Parts, Goals, Scope),
    sources(Goals, Steps0),
    from_sources(Mode, Test, Steps0, Scope, FromTest, Steps),
    maplist(step_code(Scope, Context), Steps, Codes0),
    outline_code(Mode, FromTest, Context, TestCode, Outline),
    append(Codes0, [TestCode], Codes),
    conjunction(Codes, Goal),
    term_variables(Thing-Parts, Given),
    line_goal(Number, Goal, Given-Outline, Outline, Context, Outlines, All),
    term_variables(Test-Goals, Used),
    include(among(Used), Given, Inputs),
    term_variables(Parts, PartVariables),
    (   Mode == outline,
        Inputs \== [],
        \+ forall(member(Part, PartVariables), among(Inputs, Part))
    ->  append(Inputs, [Outlines], Args),
        helper(Context, kept(Head, Test), Args, Kept, true),
        put_remembered(Context, Kept, Inputs, [Outlines], All),
        Code = Kept
    ;   Code = All
    ).

step_code(Scope, Context, Step, Code) :-
    (   Step = source(_, _, _, _, _)
    ->  source_code(Step, Scope, Context, Code)
    ;   Context = context(Module, _, _),
        body_code(Module:Step, Context, Code)
    ).

%   In a full outline all is asked in the order that the proof has.
from_sources(full, Test, Steps, _, Test, Steps).
from_sources(outline, Test, Steps0, Scope, FromTest, Steps) :-
    from(Test, Steps0, Scope, FromTest),
    exclude(replaced(FromTest, Steps0), Steps0, Steps).

%   Nothing asks for its list any more.
replaced(Test, Steps, source(_, _, _, _, Xs)) :-
    \+ ( member(Term, [Test|Steps]), asks_for(Term, Xs) ).

asks_for(Term, Xs) :- var(Term), !, Term == Xs.
asks_for(source(_, Goals, Excluded, Test, _), Xs) :- !, asks_for(Goals-Excluded-Test, Xs).
asks_for(from(_, Goals, Excluded, Test, _), Xs) :- !, asks_for(Goals-Excluded-Test, Xs).
asks_for(Term, Xs) :- compound(Term), arg(_, Term, Arg), asks_for(Arg, Xs), !.

%   A quantifier over what a source gives is written over the source.
from(Test, _, _, Test) :- var(Test), !.
from(each(X, List, Test), Sources, Scope, each(X, From, Test)) :-
    from_source(List, Sources, Scope, From),
    !.
from(some(X, List, Test), Sources, Scope, some(X, From, Test)) :-
    from_source(List, Sources, Scope, From),
    !.
from(each_pair(X, Y, List, Test), Sources, Scope, each_pair(X, Y, From, Test)) :-
    from_source(List, Sources, Scope, From),
    !.
from(Test0, Sources, Scope, Test) :-
    Test0 =.. [Name|Args0],
    memberchk(Name/Args0, [all/[_], any/[_], not/[_], if_known/[_], expect/[_, _], implies/[_, _]]),
    !,
    maplist(from_arg(Sources, Scope), Args0, Args),
    Test =.. [Name|Args].
from(Test, _, _, Test).

from_arg(Sources, Scope, Arg0, Arg) :-
    (   is_list(Arg0)
    ->  maplist(from_arg(Sources, Scope), Arg0, Arg)
    ;   from(Arg0, Sources, Scope, Arg)
    ).

%   The source is that of the variable List, which is then not asked for.
from_source(List, Sources, Scope, from(X, Goals, Excluded, Test, Scope)) :-
    var(List),
    member(source(X, Goals, Excluded, Test, Xs), Sources),
    Xs == List,
    !.

line_goal(one, Goal, _, Outline, _, Outlines, ( Goal -> Outlines = [Outline] ; Outlines = [] )).
line_goal(several, Goal, Source, Outline, Context, Outlines, findall(Outline, Call, Outlines)) :-
    called(Goal, Source, Context, Call).

%!  first_code(+Context, +Line, +Name, -First) is det.
%
%   To see that a condition which searches fails takes less than to say by how much: First(Thing,
%   Parts) fails then. It is `none` if there is nothing to gain.

first_code(Context, line(_, Thing, Parts, Test, Body), Name, First) :-
    (   Body == true
    ->  First = none
    ;   cases_of(Context, Thing, Test, Body, Cases),
        first_case(Cases, Thing-Parts, Context, Code),
        helper(Context, first(Name), [Thing, Parts], Head, true),
        functor(Head, First, 2),
        put_clause(Context, (Head :- !, Code)),
        ( Thing-Parts =@= _-_ -> true ; functor(Other, First, 2), put_clause(Context, Other) )
    ).

first_case(either(Goal, IfSo, IfNot), Given, Context, ( Goal -> CodeIfSo ; CodeIfNot )) :-
    first_case(IfSo, Given, Context, CodeIfSo),
    first_case(IfNot, Given, Context, CodeIfNot).
first_case(one(Test-Goals), Thing-Parts, Context, Code) :-
    scope(Thing, Parts, Goals, Scope),
    sources(Goals, Steps),
    maplist(step_code(Scope, Context), Steps, Codes0),
    conjunction(Codes0, Body),
    state_code(possible, Test, Context, Possible),
    Code = ( Body -> ( Possible -> true ; fail ) ; true ).
