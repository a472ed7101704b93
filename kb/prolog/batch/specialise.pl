:- module(facetlog_specialise, [ specialised/2,       % +Module, +Context
                                 all_said/5,           % +Names, +Target, +Thing, +Parts, -Said
                                 all_outlined/5        % +Names, +Target, +Thing, +Parts, -Outline
                               ]).

/** <module> Rules for one scene after the other

A batch asks the same few models of thousands of scenes. For that a module of rules is written anew
once: what its goals ask of the vocabulary is copied beside it (body_code.pl), each test becomes the
Prolog that works out just that test (state_code.pl, outline_code.pl), and every fact is asked of one module, which
holds one scene at a time. What was asked of a scene once is remembered until the next.

Context is context(Module, Target, Crisp): the rules, the module of the facts and of the new clauses,
and whether values are exact. What cannot be written anew is asked as always, and costs what
it always did; nothing is judged in another way.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(line_code)).
:- use_module(facetlog_kb(sources)).
:- use_module(facetlog_kb(seen_through)).
:- use_module(facetlog_kb(outlines)).
:- use_module(facetlog_kb(measure_code)).
:- use_module(facetlog_kb(search)).

%!  specialised(+Module, +Context) is det.
%
%   Target can judge the models of Module from now on. It has
%
%     - candidate(Model, Thing, Parts), nondet, as the module itself;
%     - plan(Model, Plan): a list of ask(Name, Most, First), the cheapest first. Name(Thing,
%       Parts, Said) gives what the conditions of one label say (misses.pl); Most is as in search.pl.
%       First(Thing, Parts) fails if the only condition does, and is seen sooner; or it is `none`;
%     - lines(Model, Names): Name(Thing, Parts, Outlines) in the order of the file;
%     - group(Model, Thing, Parts, Role, Members), nondet;
%     - size(Model, Thing, Parts, Name, Value, Variance), nondet.

specialised(Module, Context) :-
    findall(Model, Module:model(Model, _, _), Models),
    current_prolog_flag(optimise, Before),
    setup_call_cleanup(
        set_prolog_flag(optimise, true),    % arithmetic is most of the work
        maplist(model_code(Context), Models),
        set_prolog_flag(optimise, Before)).

model_code(Context, Model) :-
    Context = context(Module, _, _),
    body_code(Module:candidate(Model, Thing, Parts), Context, Candidate),
    put_clause(Context, (candidate(Model, Thing, Parts) :- Candidate)),
    plan(Module, Model, Plan0),
    asks(Plan0, Context, Model, Plan),
    put_clause(Context, plan(Model, Plan)),
    findall(line(Label, LineThing, LineParts, Test, Body),
            clause(Module:condition(Model, Label, _, LineThing, LineParts, Test), Body),
            Lines),
    maplist(line_code(full, Context, Model, several), Lines, Names),
    put_clause(Context, lines(Model, Names)),
    put_clause(Context, (group(Model, _, _, _, _) :- fail)),
    (   current_predicate(Module:group/5)
    ->  forall(clause(Module:group(Model, GroupThing, GroupParts, Role, Members), GroupBody),
               group_code(Context, Model, GroupThing, GroupParts, Role, Members, GroupBody))
    ;   true
    ),
    put_clause(Context, (size(Model, _, _, _, _, _) :- fail)),
    (   current_predicate(Module:size/5)
    ->  forall(clause(Module:size(Model, SizeThing, SizeParts, Name, Measure), Body),
               size_code(Context, Model, SizeThing, SizeParts, Name, Measure, Body))
    ;   true
    ).

%   The conditions of each group of a plan in one predicate.
asks([], _, _, []).
asks([group(Label, Most)|Groups], Context, Model, [ask(Name, Most, First)|Asks]) :-
    Context = context(Module, _, _),
    findall(line(Label, Thing, Parts, Test, Body),
            clause(Module:condition(Model, Label, _, Thing, Parts, Test), Body),
            Lines),
    ( Groups = [group(_, After)|_] -> true ; After = 0 ),
    (   Lines = [Line],
        Most =:= After + 1
    ->  line_code(search, Context, Model, one, Line, Name),
        first_code(Context, Line, Name, First)
    ;   First = none,   maplist(line_code(search, Context, Model, several), Lines, Names),
        group_of_lines(Context, Names, Name)
    ),
    asks(Groups, Context, Model, Asks).

group_of_lines(Context, Names, Name) :-
    helper(Context, lines(Names), [Thing, Parts, Said], Head, _),
    functor(Head, Name, _),
    Context = context(_, Target, _),
    put_clause(Context, (Head :- facetlog_specialise:all_said(Names, Target, Thing, Parts, Said))).

%!  all_said(+Names, +Target, +Thing, +Parts, -Said) is det.
%
%   What the predicates Names give, one after the other.

all_said([], _, _, _, []).
all_said([Name|Names], Target, Thing, Parts, Said) :-
    call(Target:Name, Thing, Parts, First),
    append(First, Rest, Said),
    all_said(Names, Target, Thing, Parts, Rest).

%!  all_outlined(+Names, +Target, +Thing, +Parts, -Outline) is det.
%
%   What the outlines that the predicates Names give come to together.

all_outlined(Names, Target, Thing, Parts, Outline) :-
    outlined(Names, Target, Thing, Parts, outline(holds, 1, 1, 0), Outline).

outlined([], _, _, _, Outline, Outline).
outlined([Name|Names], Target, Thing, Parts, Outline0, Outline) :-
    call(Target:Name, Thing, Parts, Outlines),
    all_of([Outline0|Outlines], Outline1),
    (   Outline1 = outline(fails, _, High, _),
        High =:= 0
    ->  Outline = Outline1              % nothing can change that any more
    ;   outlined(Names, Target, Thing, Parts, Outline1, Outline)
    ).

%   What the conditions go through the groups go through again.
group_code(Context, Model, Thing, Parts, Role, Members, Body) :-
    Context = context(Module, _, _),
    written_body(Module, Body, Goals),
    scope(Thing, Parts, Goals, Scope),
    sources(Goals, Steps),
    maplist(step_code(Scope, Context), Steps, Codes),
    conjunction(Codes, Code),
    put_clause(Context, (group(Model, Thing, Parts, Role, Members) :- Code)).

size_code(Context, Model, Thing, Parts, Name, Measure, Body0) :-
    Context = context(Module, _, _),
    written_body(Module, Body0, Goals),
    conjunction(Goals, Written),
    body_code(Module:Written, Context, Body),
    (   value_code(Measure, Context, Goal, V, Var, Kind)
    ->  Kind == length,
        Value = Goal
    ;   Value = facetlog_quantities:value(Measure, Module, quantity(V, Var, length)),
        % Which of several was worked out while they were sorted.
        ( var(Measure), sub_goal(longest_first(Ms, _), Written), is_list(Ms) -> true
        ; asks_all(Context) )
    ),
    put_clause(Context, (size(Model, Thing, Parts, Name, V, Var) :- Body, Value)).

sub_goal(Goal, Goal).
sub_goal(Goal, (A, B)) :- ( sub_goal(Goal, A) ; sub_goal(Goal, B) ).
