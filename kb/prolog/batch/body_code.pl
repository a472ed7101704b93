:- module(facetlog_body_code, [ body_code/3,          % +Goal, +Context, -Code
                                listed_code/8,        % +Order, +Inputs, +X, +Goals, ... -Xs, -Code
                                conjuncts/2,          % +Goal, -Goals
                                conjunction/2         % +Codes, -Code
                              ]).

/** <module> Goals of rules into goals of one scene

A predicate that asks the scene for facts, itself or through others, is copied into the target with
its facts called in the scene's module; so are the rules' own predicates. What asks for no fact is
called where it is. Context is as in specialise.pl.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(partial)).
:- use_module(facetlog_kb(first_answer)).
:- use_module(facetlog_kb(joins)).

%   Modules whose predicates may ask for facts, beside that of the rules.
fact_asking(vocabulary).
fact_asking(measures).
fact_asking(grouping).
fact_asking(line_labels).

%!  body_code(+Goal, +Context, -Code) is det.
%
%   Code does in the target what Module:Goal does where it stands.

body_code(Goal, _, _) :-
    var(Goal),
    throw(facetlog_general(Goal)).
body_code(Module:Goal, Context, Code) :-
    code(Goal, Module, Context, Code).

code(Goal, _, _, _) :-
    var(Goal),
    throw(facetlog_general(Goal)).      % the caller leaves the model as it is
code(true, _, _, true) :- !.
code(!, _, _, !) :- !.
code(Module:Goal, _, Context, Code) :-
    !,
    ( var(Module) -> throw(facetlog_general(Goal)) ; code(Goal, Module, Context, Code) ).
code(fact(Fact), _, Context, Code) :- !, fact_code(Fact, Context, Code).
code(in(_, _), _, _, _) :- throw(facetlog_general(in)).
code(possible(Test), Module, Context, Code) :- !, test_goal(possible, Test, Module, Context, Code).
code(holds(Test), Module, Context, Code) :- !, test_goal(holds, Test, Module, Context, Code).
code(chosen(Inputs, X, Goals), Module, Context, Code) :-
    !,
    listed_code(as_found, Inputs, X, Goals, Module, Context, Xs, Listed),
    Code = ( Listed, lists:member(X, Xs) ).
code(among_chosen(Inputs, X, Goals), Module, Context, Code) :-
    !,
    listed_code(as_found, Inputs, X, Goals, Module, Context, Xs, Listed),
    Code = ( Listed, memberchk(X, Xs) ).
code(as_far_as_seen(Thing, Steps, Parts), Module, Context, Code) :-
    !,
    seen_code(Thing, Steps, Parts, Module, Context, Code).
code(longest_first(Measures, Sorted), Module, Context, Code) :-
    !,
    sorted_code(Measures, Sorted, Module, Context, Code).
code(measure(Measure, V, Sd, Kind), measures, Context, Code) :-
    callable(Measure),
    attempt(Context, facetlog_unknown(_),
            first_answer_code(Measure, V, Sd, Kind, Context, Code)),
    !.
code(measure(Measure, V, Sd, Kind), _, Context, Code) :-
    !,
    asks_all(Context),
    Code = measures:measure(Measure, V, Sd, Kind).
code(Goal, Module, Context, Code) :-
    control(Goal, Goals, Code, Codes),
    !,
    maplist(code_in(Module, Context), Goals, Codes).
code(recall(_, _, _, _, _, Goal), Module, Context, ( Code -> true )) :-
    !,                                  % what is asked again is kept by first_answer.pl
    code(Goal, Module, Context, Code).
code(Goal, Module, Context, Code) :-
    predicate_property(Module:Goal, meta_predicate(Head)),
    Head =.. [_|Modes],
    member(Mode, Modes),
    calls(Mode),
    !,
    Goal =.. [Name|Args0],
    maplist(meta_code(Module, Context), Modes, Args0, Args1),
    placed(Goal, Module, Place),
    (   Place = Source:_
    ->  Context = context(_, Target, _),
        maplist(qualified(Target), Modes, Args1, Args),
        Code0 =.. [Name|Args],
        Code = Source:Code0
    ;   Code =.. [Name|Args1]
    ).
code(Goal, Module, Context, Code) :-
    predicate_property(Module:Goal, meta_predicate(Head)),
    Head =.. [_|Modes],
    memberchk(:, Modes),
    !,
    ( reaches_facts(Goal, Module) -> asks_all(Context) ; true ),
    qualified_call(Module, Goal, Code).     % tests among its arguments are those of Module
code(Goal, Module, Context, Code) :-
    source(Goal, Module, Context, Source),
    !,
    copy(Source, Goal, Context, Code).
code(Goal, Module, Context, Code) :-
    ( reaches_facts(Goal, Module) -> asks_all(Context) ; true ),
    placed(Goal, Module, Code).

code_in(Module, Context, Goal, Code) :-
    code(Goal, Module, Context, Code).

control((A, B), [A, B], (C, D), [C, D]).
control((A ; B), [A, B], (C ; D), [C, D]).
control((A -> B), [A, B], (C -> D), [C, D]).
control((A *-> B), [A, B], (C *-> D), [C, D]).
control(\+ A, [A], \+ B, [B]).

calls(0).
calls(^).
calls(Extra) :- integer(Extra), Extra > 0.

meta_code(Module, Context, 0, Goal, Call) :-
    !,
    code(Goal, Module, Context, Code),
    called(Code, Goal, Context, Call).
meta_code(Module, Context, ^, Goal0, Code) :-
    !,
    hidden(Goal0, Goal, Code, Call),
    code(Goal, Module, Context, Code0),
    called(Code0, Goal, Context, Call).
meta_code(Module, Context, Extra, Closure, Code) :-
    integer(Extra),
    !,
    closure_code(Closure, Extra, Module, Context, Code).
meta_code(_, _, _, Arg, Arg).

%   A closure is a goal that lacks its last arguments.
closure_code(Closure, Extra, Module, Context, Code) :-
    length(Lacking, Extra),
    (   callable(Closure),
        Closure \= _:_,
        Closure \= (_ >> _),
        Closure =.. [Name|Args],
        append(Args, Lacking, AllArgs),
        Goal =.. [Name|AllArgs],
        code(Goal, Module, Context, Code0),
        without_last(Code0, Lacking, Code1)
    ->  Code = Code1
    ;   throw(facetlog_general(Closure))
    ).

without_last(Source:Goal0, Lacking, Source:Goal) :-
    without_last(Goal0, Lacking, Goal).
without_last(Goal0, Lacking, Goal) :-
    Goal0 =.. [Name|Args0],
    append(Args, Last, Args0),
    Last == Lacking,
    Goal =.. [Name|Args].

%   The module of a goal that is called in another module is said.
qualified(Target, Mode, Arg, Code) :-
    (   calls(Mode),
        Arg \= _:_
    ->  Code = Target:Arg
    ;   Code = Arg
    ).

hidden(Goal0, Goal, Code0, Code) :-
    (   nonvar(Goal0),
        Goal0 = V^Goal1
    ->  Code0 = V^Code1,
        hidden(Goal1, Goal, Code1, Code)
    ;   Goal = Goal0,
        Code0 = Code
    ).

%   What other predicates of the program do with the scene needs all its facts.
reaches_facts(Goal, Module) :-
    defined_in(Goal, Module, Source),
    ( fact_asking(Source) -> true ; atom_concat(facetlog_, _, Source) ).

                 /*******************************
                 *             FACTS            *
                 *******************************/

fact_code(Fact, Context, Code) :-
    Context = context(_, Target, _),
    (   callable(Fact)
    ->  functor(Fact, Name, Arity),
        (   fact_schema(Name/Arity, _)
        ->  note(Target, Name/Arity)
        ;   true
        ),
        Code = Fact
    ;   asks_all(Context),
        Code = call(Target:Fact)
    ).

                 /*******************************
                 *            COPIES            *
                 *******************************/

%   Source is the module in which a predicate stands that is to be copied.
source(Goal, Module, context(Rules, _, _), Source) :-
    defined_in(Goal, Module, Source),
    ( Source == Rules -> true ; fact_asking(Source) ),
    predicate_property(Source:Goal, number_of_clauses(_)).

copy(Source, Goal, Context, Code) :-
    Context = context(_, Target, _),
    functor(Goal, Name, Arity),
    atomic_list_concat([Source, :, Name], New),
    (   copied(Target, New/Arity)
    ->  true
    ;   copy_noted(Target, New/Arity),      % first: it may call itself
        functor(Head, Name, Arity),
        findall(Head-Body, clause(Source:Head, Body), Clauses),
        functor(NewHead, New, Arity),
        declared(Target, NewHead),
        (   once_a_scene(Source, Head, How)
        ->  atom_concat(New, ' anew', Anew),
            functor(AnewHead, Anew, Arity),
            copy_clauses(Clauses, Source, Anew, Context),
            kept_answers(How, NewHead, AnewHead, Context)
        ;   copy_clauses(Clauses, Source, New, Context)
        )
    ),
    Goal =.. [_|Args],
    Code =.. [New|Args].

%!  listed_code(+Order, +Inputs, +X, +Goals, +Module, +Context, -Xs, -Code) is det.
%
%   Code finds Xs, all X for which Goals of Module succeed: for the Inputs on which that depends it is worked
%   out once a scene. Order is `as_found` or `sorted`, each once.

listed_code(Order, Inputs, X, Goals, Module, Context, Xs, Code) :-
    copy_term(Inputs-X-Goals, Inputs1-X1-Goals1),
    append(Inputs1, [Xs1], Args1),
    helper(Context, listed(Order, Module, Inputs1, X1, Goals1), Args1, Head, New),
    (   New == true
    ->  conjunction(Goals1, Goal),
        collected(Order, X1, Goal, Xs1, Collected),
        code(Collected, Module, Context, Body),
        put_remembered(Context, Head, Inputs1, [Xs1], Body)
    ;   true
    ),
    Head =.. [Name|_],
    append(Inputs, [Xs], Args),
    Code =.. [Name|Args].

collected(as_found, X, Goal, Xs, findall(X, Goal, Xs)).
collected(sorted, X, Goal, Xs, ( findall(X, Goal, Found), sort(Found, Xs) )).

%   Words that go through the whole thing, and are asked again and again: a function of their first
%   argument (det or semidet), or some answers for it (nondet).
once_a_scene(grouping, separate(_, _), function).
once_a_scene(grouping, narrow_foot(_, _), function).
once_a_scene(line_labels, labels_of_view(_, _), function).
once_a_scene(vocabulary, largest_faces(_, _), function).
once_a_scene(vocabulary, largest_pieces(_, _), function).
once_a_scene(vocabulary, piece_in(_, _), answers).
once_a_scene(vocabulary, largest_openings(_, _), function).
once_a_scene(vocabulary, opening_through(_, _), answers).
once_a_scene(vocabulary, largest_hollows(_, _), function).
once_a_scene(vocabulary, hollow_in(_, _), answers).
once_a_scene(vocabulary, face_of(_, _), answers).
once_a_scene(vocabulary, element_of(_, _), answers).

kept_answers(function, Head, Anew, Context) :-
    Head =.. [_, Given, Answer],
    Anew =.. [_, Given, Answer],
    put_remembered(Context, Head, [Given], [Answer], Anew).
kept_answers(answers, Head, Anew, Context) :-
    Head =.. [Name, Given, Answer],
    Anew =.. [_, Given, Answer],
    atom_concat(Name, ' all', All),
    Kept =.. [All, Given, Answers],
    put_remembered(Context, Kept, [Given], [Answers],
                   ( findall(Answer, Anew, Found), sort(Found, Answers) )),
    put_clause(Context, (Head :- nonvar(Given), !, Kept, lists:member(Answer, Answers))),
    put_clause(Context, (Head :- Anew)).

%   All or none: one may not be seen through.
copy_clauses(Clauses, Source, New, Context) :-
    maplist(copy_clause(Source, New, Context), Clauses, Copies),
    maplist(put_clause(Context), Copies).

copy_clause(Source, New, Context, Head-Body0, (NewHead :- Body)) :-
    Head =.. [_|Args],
    NewHead =.. [New|Args],
    by_pairs(Body0, Body1),
    code(Body1, Source, Context, Body).

                 /*******************************
                 *       TESTS AND PARTS        *
                 *******************************/

test_goal(Wanted, Test, Module, Context0, Code) :-
    in_module(Context0, Module, Context),
    (   var(Test)
    ->  throw(facetlog_general(Test))
    ;   said_code(Test, state, Context, said(State, _), Code0),
        wanted_code(Wanted, State, Wish),
        conjunction([Code0, Wish], Code)
    ).

wanted_code(Wanted, State, Wish) :-
    (   var(State)
    ->  ( Wanted == holds -> Wish = ( State == holds ) ; Wish = ( State \== fails ) )
    ;   ( State == holds ; State == unknown, Wanted == possible )
    ->  Wish = true
    ;   Wish = fail
    ).

%   Words and tolerances of a test are those of the module in which it stands.
in_module(context(_, Target, Crisp), Module, context(Module, Target, Crisp)).

seen_code(Thing, Steps0, Parts, Module, Context, Code) :-
    is_list(Steps0),
    maplist(step_code(Module, Context), Steps0, Steps),
    code(largest_faces(Thing, Faces), vocabulary, Context, Largest),
    maplist(part_of_step, Steps0, Variables),
    Context = context(_, Target, _),
    maplist(in_target(Target), Steps, Run),
    Code = ( Variables = Parts, Largest,
             facetlog_seen_parts:seen_parts(Run, Faces) ).

part_of_step(step(Part, _, _), Part).

step_code(Module, Context, step(Part, Count, Test), step(Part, Count, Call)) :-
    var(Part),
    integer(Count),
    test_goal(possible, Test, Module, Context, Code),
    called(Code, Test, Context, Call).

in_target(Target, step(Part, Count, Code), step(Part, Count, Target:Code)).

sorted_code(Measures, Sorted, Module, Context0, Code) :-
    in_module(Context0, Module, Context),
    (   is_list(Measures),
        attempt(Context, facetlog_unknown(_),
                maplist(one_value(Context), Measures, Goals, Values))
    ->  foldl(joined, Goals, true, Known),
        pairs(Values, Measures, Pairs),
        Code = ( Known, sort(1, @>=, Pairs, Descending), pairs:pairs_values(Descending, Sorted) )
    ;   asks_all(Context),
        Code = facetlog_quantities:longest_first_in(Module, Measures, Sorted)
    ).

one_value(Context, Measure, Goal, V) :-
    value_code(Measure, Context, V, Goal).

joined(Goal, Before, (Before, Goal)).

pairs([], [], []).
pairs([V|Vs], [M|Ms], [V-M|Ps]) :- pairs(Vs, Ms, Ps).

                 /*******************************
                 *         CONJUNCTIONS         *
                 *******************************/

%!  conjuncts(+Goal, -Goals) is det.
%
%   The steps of a goal.

conjuncts(Goal, [Goal]) :- var(Goal), !.
conjuncts(true, []) :- !.
conjuncts((A, B), Goals) :-
    !,
    conjuncts(A, As),
    conjuncts(B, Bs),
    append(As, Bs, Goals).
conjuncts(Goal, [Goal]).

%!  conjunction(+Codes, -Code) is det.

conjunction([], true).
conjunction([Code|Codes], All) :- foldl(and_then, Codes, Code, All).

and_then(Code, Before, All) :-
    (   Code == true
    ->  All = Before
    ;   Before == true
    ->  All = Code
    ;   All = ( Before, Code )
    ).
