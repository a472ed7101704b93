% The module that rules are specialised into: what is made once, forgotten, and remembered of a scene.
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(rule_module)).

:- begin_tests(target).

in_target(Goal, Context) :-
    gensym(target, Target),
    Context = context(user, Target, false),
    setup_call_cleanup(
        new_rule_module(Target),
        once(Goal),
        ( forget_code(Target), '$destroy_module'(Target) )).

test(one_predicate_for_what_is_alike, News-Same == [true, false, true, true]-true) :-
    in_target(( helper(C, of(X, f), [X, a], One, N1), helper(C, of(Y, f), [Y, b], Two, N2),
                helper(C, of(f, Y), [Y, b], _, N3), helper(C, of(Y, f), [Y], _, N4) ), C),
    News = [N1, N2, N3, N4],
    ( One =.. [Name, X, a], Two =.. [Name, Y, b] -> Same = true ; Same = false ).
test(what_was_begun_is_forgotten, News == [false, true]) :-
    in_target(( helper(C, before, [], _, _),
                \+ attempt(C, stop(_), ( helper(C, key, [], _, _), throw(stop(here)) )),
                helper(C, before, [], _, N1), helper(C, key, [], _, N2) ), C),
    News = [N1, N2].
test(copies_that_were_begun_are_forgotten, Copied == [a/1]) :-
    in_target(( C = context(_, Target, _), copy_noted(Target, a/1),
                \+ attempt(C, stop, ( copy_noted(Target, b/1), throw(stop) )),
                findall(Copy, copied(Target, Copy), Copied) ), C).
test(what_succeeds_is_kept, X-New == 1-false) :-
    in_target(( attempt(C, stop, ( helper(C, key, [], _, _), member(X, [1, 2]) )), helper(C, key, [], _, New) ), C).
test(other_errors_pass, throws(other)) :-
    in_target(attempt(C, stop, throw(other)), C).

% A predicate that counts how often its body runs.
remembering(C, Target, Head, X, Y) :-
    C = context(_, Target, _),
    helper(C, counting, [X, Y], Head, true),
    put_remembered(C, Head, [X], [Y], user:counted(X, Y)).

test(worked_out_once_a_scene, Found-Count == [1-1, 1-1, 2-none]-2) :-
    flag(target_asked, _, 0),
    in_target(( remembering(C, Target, Head, X, Y),
                findall(X-Found1, ( member(X, [1, 1, 2]), ( call(Target:Head) -> Found1 = Y ; Found1 = none ) ), Found) ),
              C),
    flag(target_asked, Count, Count).
test(for_the_next_scene_again, Count == 2) :-
    flag(target_asked, _, 0),
    in_target(( remembering(C, Target, Head, 1, _), forall(member(_, [a, b]), ( call(Target:Head), forget_remembered(Target) )) ),
              C),
    flag(target_asked, Count, Count).
test(not_remembered_of_what_is_not_known, Answers == [1, 1]) :-
    in_target(( remembering(C, Target, Head, X, Y),
                findall(Y, ( member(_, [a, b]), \+ \+ call(Target:Head), ( X = 1, call(Target:Head) ) ), Answers) ), C).
test(as_one_call, Codes == [f(a), true]) :-
    in_target(( called(f(a), f(a), C, Code), called(( f(X), g(X, _) ), X, C, Call) ), C),
    Codes = [Code, One],
    ( Call =.. [_, Y], Y == X -> One = true ; One = Call ).
test(control_is_called_as_one, forall(member(Code, [ ( a, b ), ( a ; b ), ( a -> b ), ( a *-> b ), \+ a ]))) :-
    in_target(( called(Code, [], C, Call), called(Code, [], C, Again), Again == Call, C = context(_, Target, _), clause(Target:Call, Body) ), C),
    assertion(Body == Code).

% Whether code for these goals leaves something to the modules that judge any test.
interpreting(facetlog_say:said(t, user, state, _), true).
interpreting(facetlog_search:outlines(_, _, _, _, _, _), true).
interpreting(facetlog_quantities:value(_, user, _), true).
interpreting(facetlog_quantities:longest_first_in(user, _, _), true).
interpreting(measures:measure(_, _, _, _), true).
interpreting(( a, ( b -> facetlog_say:said(_, _, _, _) ; true ) ), true).
interpreting(facetlog_forms:joint_miss(_, _), false).
interpreting(lists:member(_, [said(_, _, _, _)]), false).
interpreting(said(_, _, _, _), false).

test(what_is_interpreted, forall(interpreting(Goal, Expected))) :-
    in_target(( helper(C, inner, [], Inner, true), helper(C, outer, [X], Outer, true),
                put_clause(C, ( Inner :- X = 1, Goal )), put_clause(C, ( Inner :- Outer )),
                put_clause(C, ( Outer :- findall(x, Inner, X) )),
                C = context(_, Target, _), functor(Outer, Name, 1),
                ( calls_interpreter(Target, Name/1) -> Found = true ; Found = false ) ), C),
    assertion(Goal-Found == Goal-Expected).
test(facts_that_are_asked_for, Asked == [a/1, b/2]) :-
    in_target(( C = context(_, Target, _), note(Target, a/1), note(Target, b/2), note(Target, a/1),
                findall(Fact, asked_of_scene(Target, Fact), Asked) ), C).
test(any_fact, Asked == All) :-
    in_target(( C = context(_, Target, _), note(Target, a/1), asks_all(C), findall(Fact, asked_of_scene(Target, Fact), Asked) ), C),
    findall(Fact, schema:fact_schema(Fact, _), All).
test(where_a_goal_is_called, Codes == [lists:append(a, b, c), length(a, b), user:own(a)]) :-
    maplist([Goal, Code]>>placed(Goal, user, Code), [append(a, b, c), length(a, b), own(a)], Codes).

:- end_tests(target).

counted(1, 1) :- flag(target_asked, N, N + 1).
counted(2, _) :- flag(target_asked, N, N + 1), fail.
