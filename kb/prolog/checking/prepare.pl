:- module(facetlog_prepare, [ prepared/4,          % +Goal, +Scope, +Module, -Runnable
                              lambda/4,            % +Shared, +Parameters, :Goal, ?A
                              lambda/5,            % +Shared, +Parameters, :Goal, ?A, ?B
                              lambda/6,            % +Shared, +Parameters, :Goal, ?A, ?B, ?C
                              lambda/7,            % ... ?D
                              lambda/8,            % ... ?D, ?E
                              holds_in/2,          % +Module, +Test
                              possible_in/2        % +Module, +Test
                            ]).

/** <module> Checked goals into goals that run

The text says what is meant; what runs is bounded, and finds the facts. Numbers in expressions are
seen to be short, text is counted, facts of a question are looked up in the current scene.
*/

:- use_module(library(assoc)).
:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(yall)).
:- use_module(library(error)).
:- use_module(facetlog_kb(check)).
:- use_module(facetlog_kb(white_list)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(bounded_numbers)).
:- use_module(facetlog_kb(bounded_text)).
:- use_module(facetlog_kb(python)).
:- use_module(facetlog(vocabulary)).

:- meta_predicate
    lambda(+, +, 0, ?),
    lambda(+, +, 0, ?, ?),
    lambda(+, +, 0, ?, ?, ?),
    lambda(+, +, 0, ?, ?, ?, ?),
    lambda(+, +, 0, ?, ?, ?, ?, ?).

%!  prepared(+Goal, +Scope, +Module, -Runnable) is det.
%
%   Runnable is what Goal, in which goal_fault/4 finds no fault, stands for in Module.

prepared(Goal, Scope, Module, Runnable) :-
    (   functor(Goal, Name, Arity),
        get_assoc(Name/Arity, Scope, _)
    ->  python_call(Goal, Name/Arity, Runnable)
    ;   allowed_word(Goal, Head)
    ->  prepared_arguments(Head, Goal, Scope, Module, Goal1, Guards),
        bounded(Goal1, Goal2),
        conjunction(Guards, Goal2, Runnable)
    ;   search_prepared(Goal, Scope, Module, Runnable)
    ).

%   What a question's own words are, the knowledge base has defined in Python.
python_call(Goal, Indicator, call_python(Key, Args)) :-
    nb_current(facetlog_base, Base-_),
    python_predicate(Base, Indicator, Key),
    Goal =.. [_|Args].

search_prepared(in(Scene, Goal), Scope, Module, in(Scene, Runnable)) :-
    !,
    prepared(Goal, Scope, Module, Runnable).
search_prepared(holds(Test), _, Module, holds_in(Module, Test)) :- !.
search_prepared(possible(Test), _, Module, possible_in(Module, Test)) :- !.
search_prepared(each_pair(X, Y, Faces, Test), _, Module, each_pair_in(Module, X, Y, Faces, Test)) :-
    !.
search_prepared(as_far_as_seen(Thing, Steps, Parts), _, Module,
                as_far_as_seen_in(Module, Thing, Steps, Parts)) :-
    !.
search_prepared(longest_first(Measures, Sorted), _, Module,
                longest_first_in(Module, Measures, Sorted)) :-
    !.
search_prepared(Goal, _, _, fact(Goal)) :-
    functor(Goal, Name, Arity),
    \+ search_word(Name/Arity),
    fact_word(Goal),
    !.
search_prepared(Goal, _, _, Goal).

conjunction([], Goal, Goal).
conjunction([Guard|Guards], Goal, (Guard, Rest)) :-
    conjunction(Guards, Goal, Rest).

                 /*******************************
                 *           ARGUMENTS          *
                 *******************************/

prepared_arguments(Head, Goal, Scope, Module, Prepared, Guards) :-
    Head =.. [Name|Sorts],
    Goal =.. [_|Args0],
    (   summary_goal(Sorts, Args0, Args1, Index, Guards0)
    ->  % What is summed up is seen to be short after each way of the goal.
        guarded_argument(Args1, Index, Guards0, Scope, Module, Args),
        Prepared =.. [Name|Args],
        Guards = []
    ;   foldl(prepared_argument(Scope, Module), Sorts, Args0, Args, [], Guards1),
        reverse(Guards1, Guards),
        Prepared =.. [Name|Args]
    ).

prepared_argument(Scope, Module, Sort, Arg0, Arg, Guards0, Guards) :-
    (   sort_prepared(Sort, Arg0, Scope, Module, Arg1, New)
    ->  Arg = Arg1,
        append(New, Guards0, Guards)
    ;   Arg = Arg0,
        Guards = Guards0
    ).

sort_prepared(goal(_), Goal0, Scope, Module, Goal, []) :-
    prepared(Goal0, Scope, Module, Goal).
sort_prepared(inner(_), Goal0, Scope, Module, Goal, []) :-
    prepared(Goal0, Scope, Module, Goal).
sort_prepared(bag(_), Goal0, Scope, Module, Goal, []) :-
    inner_goal(Goal0, Variables, Inner0),
    prepared(Inner0, Scope, Module, Inner),
    % What was put in between is no answer.
    term_variables(Inner0, Known),
    term_variables(Inner, All),
    exclude(occurs_in(Known), All, Temporary),
    append(Variables, Temporary, Hidden),
    foldl([Variable, Before, Variable^Before]>>true, Hidden, Inner, Goal).
sort_prepared(closure(Extra, _), Closure0, Scope, Module, Closure, []) :-
    extended(Closure0, Extra, Goal),
    prepared(Goal, Scope, Module, Runnable),
    (   Runnable == Goal
    ->  Closure = Closure0
    ;   Goal =.. [_|Args],
        length(Parameters, Extra),
        append(_, Parameters, Args),
        term_variables(Closure0, Shared),
        Closure = lambda(Shared, Parameters, Runnable)
    ).
sort_prepared(expression(_), Expression0, _, _, Expression, Guards) :-
    guarded(Expression0, Expression, Guards).

occurs_in(Variables, Variable) :-
    member(Known, Variables),
    Known == Variable,
    !.

                 /*******************************
                 *          ARITHMETIC          *
                 *******************************/

%   An expression may make numbers so many times longer without a look at its parts.
longer_at_most(64).

%   Guards in reverse: bounded_value/2 for each variable, or for the whole where it may get long.
guarded(Expression0, Expression, Guards) :-
    longer_at_most(Most),
    (   growth(Expression0, Factor),
        Factor =< Most
    ->  term_variables(Expression0, Variables),
        maplist([Variable, Value, bounded_value(Variable, Value)]>>true,
                Variables, Values, Guards0),
        copy_term(Variables-Expression0, Values-Expression),
        reverse(Guards0, Guards)
    ;   Guards = [bounded_value(Expression0, Expression)]
    ).

%   aggregate_all evaluates what it sums up.
summary_goal([summary(_)|Sorts], [Summary0|Args], [Summary|Args], Index, Guards) :-
    nth0(Index, [summary|Sorts], inner(_)),
    summary_guarded(Summary0, Summary, [], Guards0),
    reverse(Guards0, Guards).

summary_guarded(Summary0, Summary, Guards0, Guards) :-
    compound(Summary0),
    Summary0 =.. [Name, Expression0|Rest],
    memberchk(Name, [sum, max, min]),
    !,
    guarded(Expression0, Expression, New),
    Summary =.. [Name, Value|Rest],
    (   var(Expression)
    ->  Value = Expression,
        append(New, Guards0, Guards)
    ;   append([Value is Expression|New], Guards0, Guards)
    ).
summary_guarded(Summary, Summary, Guards, Guards) :-
    ( atom(Summary) ; Summary = bag(_) ; Summary = set(_) ),
    !.
summary_guarded(Summary0, Summary, Guards0, Guards) :-
    Summary0 =.. [Name|Parts0],
    foldl(summary_guarded, Parts0, Parts, Guards0, Guards),
    Summary =.. [Name|Parts].

guarded_argument(Args0, Index, Guards, Scope, Module, Args) :-
    nth0(Index, Args0, Goal0, Rest),
    prepared(Goal0, Scope, Module, Goal1),
    foldl([Guard, Before, (Before, Guard)]>>true, Guards, Goal1, Goal),
    nth0(Index, Args, Goal, Rest).

%   The same through a predicate that keeps numbers and text short.
bounded(Goal, Bounded) :-
    Goal =.. [Name|Args],
    length(Args, Arity),
    (   bounded_text_word(Name/Arity, New)
    ->  Bounded =.. [New|Args]
    ;   remembering(Goal, Answer)
    ->  Bounded = ( Goal, spend_on_answer(Answer) )
    ;   bounded_list_word(Name/Arity),
        Args = [List|Rest]
    ->  Direct =.. [Name, Values|Rest],
        Bounded = ( bounded_values(List, Values), Direct )
    ;   Bounded = Goal
    ).

remembering(distinct(Goal), Goal).
remembering(distinct(Witness, _), Witness).

bounded_list_word(sum_list/2).
bounded_list_word(sumlist/2).
bounded_list_word(max_list/2).
bounded_list_word(min_list/2).

                 /*******************************
                 *           RUN TIME           *
                 *******************************/

%!  lambda(+Shared, +Parameters, :Goal, ?A) is nondet.
%!  lambda(+Shared, +Parameters, :Goal, ?A, ?B) is nondet.
%!  lambda(+Shared, +Parameters, :Goal, ?A, ?B, ?C) is nondet.
%!  lambda(+Shared, +Parameters, :Goal, ?A, ?B, ?C, ?D) is nondet.
%!  lambda(+Shared, +Parameters, :Goal, ?A, ?B, ?C, ?D, ?E) is nondet.
%
%   Goal with the arguments in the place of Parameters. All its variables are fresh each time but
%   those of Shared.

lambda(Shared, Parameters, Goal, A) :-
    apply_lambda(Shared, Parameters, Goal, [A]).
lambda(Shared, Parameters, Goal, A, B) :-
    apply_lambda(Shared, Parameters, Goal, [A,B]).
lambda(Shared, Parameters, Goal, A, B, C) :-
    apply_lambda(Shared, Parameters, Goal, [A,B,C]).
lambda(Shared, Parameters, Goal, A, B, C, D) :-
    apply_lambda(Shared, Parameters, Goal, [A,B,C,D]).
lambda(Shared, Parameters, Goal, A, B, C, D, E) :-
    apply_lambda(Shared, Parameters, Goal, [A,B,C,D,E]).

apply_lambda(Shared, Parameters, Goal, Args) :-
    copy_term_nat(lambda(Shared, Parameters, Goal), lambda(Shared, Args, Copy)),
    call(Copy).

%!  holds_in(+Module, +Test) is semidet.
%!  possible_in(+Module, +Test) is semidet.
%
%   Test holds, or may hold, by the words of Module: a test that names a module would make one.

holds_in(Module, Test) :-
    in_no_module(Test),
    holds(Module:Test).

possible_in(Module, Test) :-
    in_no_module(Test),
    possible(Module:Test).

in_no_module(Test) :-
    (   nonvar(Test),
        Test = _:_
    ->  type_error(test, Test)
    ;   true
    ).
