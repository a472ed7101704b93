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
:- use_module(facetlog_kb(miss_code)).
:- use_module(facetlog_kb(seen_through)).
:- use_module(facetlog_kb(thing_cases)).
:- use_module(facetlog_kb(sources)).

%!  line_code(+Mode, +Context, +Model, +Number, +Line, -Name) is det.
%
%   Name(Thing, Parts, Said) gives what is said of Line, once or several times as Number says. Where
%   Mode is `search` that is m(State, Miss), see miss_code.pl; where it is `full` an outline, see
%   outline_code.pl.

line_code(Mode, Context, Model, Number, line(Label, Thing, Parts, Test, Body0), Name) :-
    helper(Context, line(Model, Label, Mode, Test, Body0), [Thing, Parts, Said], Head, true),
    functor(Head, Name, _),
    cases_of(Context, Thing, Test, Body0, Cases),
    case_code(Cases, leaf(Mode, Number, Thing-Parts, Context, Head), Said, Code),
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

case_code(either(Goal, IfSo, IfNot), Leaf, Said, ( Goal -> CodeIfSo ; CodeIfNot )) :-
    case_code(IfSo, Leaf, Said, CodeIfSo),
    case_code(IfNot, Leaf, Said, CodeIfNot).
case_code(one(Test-Goals), leaf(Mode, Number, Thing-Parts, Context, Head), Said, Code) :-
    scope(Thing, Parts, Goals, Scope),
    sources(Goals, Steps0),
    from_sources(Mode, Test, Steps0, Scope, FromTest, Steps),
    maplist(step_code(Scope, Context), Steps, Codes0),
    said_code(Mode, FromTest, Context, TestCode, One),
    append(Codes0, [TestCode], Codes),
    conjunction(Codes, Goal),
    term_variables(Thing-Parts, Given),
    line_goal(Number, Goal, Given-One, One, Context, Said, All),
    term_variables(Test-Goals, Used),
    include(among(Used), Given, Inputs),
    term_variables(Parts, PartVariables),
    (   Mode == search,
        Inputs \== [],
        \+ forall(member(Part, PartVariables), among(Inputs, Part))
    ->  append(Inputs, [Said], Args),
        helper(Context, kept(Head, Test, Goals), Args, Kept, New),
        % Two cases may come to the same.
        ( New == true -> put_remembered(Context, Kept, Inputs, [Said], All) ; true ),
        Code = Kept
    ;   Code = All
    ).

said_code(search, Test, Context, Code, m(State, Miss)) :- miss_code(Test, Context, Code, State, Miss).
said_code(full, Test, Context, Code, Outline) :- outline_code(Test, Context, Code, Outline).

%   In a full outline all is asked in the order that the proof has.
from_sources(full, Test, Steps, _, Test, Steps).
from_sources(search, Test, Steps0, Scope, LateTest, Steps) :-
    from(Test, Steps0, Scope, FromTest),
    exclude(replaced(FromTest, Steps0), Steps0, Steps1),
    late(FromTest, Steps1, Scope, LateTest, Steps).

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

                 /*******************************
                 *          LATE STEPS          *
                 *******************************/

%   What only one of several alternatives asks for is found when that one is asked, and the others are
%   asked before.
late(any(Tests0), Steps0, Scope, Test, Steps) :-
    is_list(Tests0),
    !,
    maplist(with_none, Tests0, Open0),
    reverse(Steps0, Reversed),
    foldl(late_step, Reversed, Open0-[], Open-Steps),
    partition(has_none, Open, Early, Late),
    append(Early, Late, Ordered),
    maplist(after(Scope), Ordered, Tests),
    Test = any(Tests).
late(Test, Steps, _, Test, Steps).

with_none(Test, Test-[]).

has_none(_-Steps) :- Steps == [].

after(_, Test-[], Test) :- !.
after(Scope, Test-Steps, after(Steps, Test, Scope)).

late_step(Step, Open0-Steps0, Open-Steps) :-
    (   found_by(Step, Found),
        \+ asks_for(Steps0, Found),
        append(Before, [Test-Later|After], Open0),
        asks_for(Test-Later, Found),
        \+ asks_for(Before-After, Found)
    ->  append(Before, [Test-[Step|Later]|After], Open),
        Steps = Steps0
    ;   Open = Open0,
        Steps = [Step|Steps0]
    ).

%   What succeeds once for certain, and what it finds.
found_by(source(_, _, _, _, Xs), Xs).
found_by(separate(_, Groups), Groups) :- var(Groups).

                 /*******************************
                 *             GOALS            *
                 *******************************/

line_goal(one, Goal, _, One, _, Said, ( Goal -> Said = [One] ; Said = [] )).
line_goal(several, Goal, Source, One, Context, Said, findall(One, Call, Said)) :-
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
    sources(Goals, Steps0),
    late(Test, Steps0, Scope, LateTest, Steps),
    maplist(step_code(Scope, Context), Steps, Codes0),
    conjunction(Codes0, Body),
    state_code(possible, LateTest, Context, Possible),
    Code = ( Body -> ( Possible -> true ; fail ) ; true ).
