% What is left of tests and of arithmetic where no scene is known: no more than the scene decides.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(arithmetic)).
:- use_module(facetlog_kb(branches)).
:- use_module(facetlog_kb(loops)).
:- use_module(facetlog_kb(partial)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(loader)).

:- begin_tests(arithmetic).

% left(Goal, Code, Known): Known holds then.
left(V is 2*3 + 1, true, V == 7).
left(7 is 2*3, fail, true).
left(6 is 2*3, true, true).
left(V is X, true, V == X).
left(V is X + 2*3, V is X + 6, var(V)).
left(V is X + 0, true, V == X).
left(V is 0 + X, true, V == X).
left(V is X - 0.0, true, V == X).
left(V is 0 - X, V is 0 - X, var(V)).
left(V is _*0, true, V == 0).
left(V is 0*_, true, V == 0).
left(V is X*1, true, V == X).
left(V is 1*X, true, V == X).
left(V is X*2, V is X*2, var(V)).
left(V is X/1, true, V == X).
left(V is 1/X, V is 1/X, var(V)).
left(V is 0/_, true, V == 0).
left(V is X/2, V is X/2, var(V)).
left(V is max(0, X + 0), V is max(0, X), var(V)).
left(V is inf, V is inf, var(V)).
left(float(1.5), true, true).
left(float(1), fail, true).
left(float(X), float(X), true).

test(what_is_left, forall(left(Goal, Left, Known))) :-
    once(arithmetic(Goal, Code)),
    assertion(Code == Left),
    assertion(Known).
test(comparisons, forall(member(Goal-Code, [ 1 < 2-true, 2 < 2-fail, 2 > 1-true, 2 > 2-fail, 2 =< 2-true, 3 =< 2-fail,
                                             2 >= 2-true, 1 >= 2-fail, 2 =:= 2.0-true, 2 =:= 3-fail, 2 =\= 3-true,
                                             2 =\= 2.0-fail ]))) :-
    once(arithmetic(Goal, Left)),
    assertion(Goal-Left == Goal-Code).
test(comparisons_of_what_is_not_known, forall(member(Name, [<, >, =<, >=, =:=, =\=]))) :-
    Goal =.. [Name, X + 0, 1 + 1],
    Expected =.. [Name, X, 2],
    once(arithmetic(Goal, Code)),
    assertion(Code == Expected),
    Turned0 =.. [Name, 1 + 1, X + 0],
    Turned =.. [Name, 2, X],
    once(arithmetic(Turned0, TurnedCode)),
    assertion(TurnedCode == Turned).
test(no_arithmetic, forall(member(Goal, [upward(_), _ == _, number(3)])), fail) :-
    arithmetic(Goal, _).

:- end_tests(arithmetic).

:- begin_tests(branches).

test(conjunctions, Codes == [a, fail, a, (a, b)]) :-
    maplist([A-B, Code]>>both(A, B, Code), [true-a, a-fail, a-true, a-b], Codes).
test(disjunctions, Codes == [a, a, (a ; b)]) :-
    maplist([A-B, Code]>>either(A, B, Code), [fail-a, a-fail, a-b], Codes).
test(variables_of_a_goal_that_code_before_knows, Shared == [B]) :-
    shared(g(_, B), h(B, _), Shared).

% What is left of a goal where all of Seen is seen by others.
branch(Goal, Seen, Code) :-
    residual(Goal, user, context(user, user, false), Seen, Code).

test(branch_binds_what_others_see, Code == ( X == 1 -> Y = a ; Y = b )) :-
    branch(( X == 1 -> Y = a ; Y = b ), [X, Y], Code).
test(names_of_what_is_seen_stay, Code == ( X == 1 -> Y is X + 2 ; Y is X + 3 )) :-
    branch(( X == 1 -> Z = X, Y is Z + 2 ; Y is X + 3 ), [X, Y], Code).
test(two_that_a_branch_makes_the_same, Code == ( Z == 1 -> Y = X ; Y = 2 )) :-
    branch(( Z == 1 -> Y = X ; Y = 2 ), [X, Y, Z], Code).
test(condition_binds_what_the_branch_asks_for, Code == ( ( X == 1 -> Z = a ; Z = b ) -> true ; Z = c )) :-
    branch(( ( X == 1 -> Y = a ; Y = b ) -> Z = Y ; Z = c ), [X, Z], Code).
test(known_condition, Code-Y == true-a) :-
    branch(( 1 < 2 -> Y = a ; Y = b ), Y, Code).
test(condition_that_cannot_be, Code-Y == true-b) :-
    branch(( 2 < 1 -> Y = a ; Y = b ), Y, Code).
test(one_of_two, Code-X == true-1) :-
    branch(( X = 1 ; X = 2 ), X, Code).
test(the_other_of_two, Code == ( X == 2 )) :-
    branch(( 2 < 1 ; X == 2 ), X, Code).
test(both_of_two, Code == ( X == 1 ; X == 2 )) :-
    branch(( X == 1 ; X == 2 ), X, Code).
test(what_follows_a_failure, Code == fail) :-
    branch(( 2 < 1, nosuch ), [], Code).
test(same, Codes == [true, fail, X == 1, fail]) :-
    maplist([Goal, Code]>>branch(Goal, [], Code), [a == a, a == b, X == 1, f(X) = g(X)], Codes).

:- end_tests(branches).

:- begin_tests(goals).

% left(Goal, Module, Code, Known): what is left of a goal of a module, and what holds then.
left(true, user, true, true).
left(fail, user, fail, true).
left(crisp, facetlog_quantities, fail, true).
left(static(sort_of(upward(_), user, Sort)), facetlog_say, true, Sort == relation).
left(static(so_far(tilt(f))), facetlog_compare, fail, true).
left(static(so_far(count([_]))), facetlog_compare, true, true).
left(call(vocabulary:fact(whole(t))), facetlog_say, whole(t), true).
left(first_measure(fill(A), V, Sd, Kind), facetlog_quantities, fill(A, V, Sd), Kind == ratio).
left(first_measure(nosuch(_), _, _, _), facetlog_quantities, fail, true).
left(length(L, 2), facetlog_quantities, length(L, 2), true).
left(must_be(nonneg, C), facetlog_say, error:must_be(nonneg, C), true).
left(total(L, S, Var), facetlog_quantities, facetlog_quantities:total(L, S, Var), true).
left(joint_miss(L, Miss), facetlog_degrees, facetlog_degrees:joint_miss(L, Miss), true).
left(plain(state, S, Said), facetlog_say, true, Said == said(S, none)).
left(value(2, user, Q), facetlog_quantities, true, Q == quantity(2, 0, number)).
left(start(at_least(2), full, Sum), facetlog_say, true, Sum == []).
left(start(nosuch, full, _), facetlog_say, fail, true).

test(what_is_left, forall(left(Goal, Module, Left, Known))) :-
    residual(Goal, Module, context(user, user, false), [], Code),
    assertion(Code == Left),
    assertion(Known).
test(exact, Code == true) :-
    residual(crisp, facetlog_quantities, context(user, user, true), [], Code).
test(what_depends_on_the_scene, forall(member(Goal-What, [ start(_, full, _)-start(_, full, _),
                                                           static(so_far(_))-so_far(_),
                                                           own_measure(user, own(f), _, _, _)-own_measure,
                                                           _-_ ]))) :-
    catch(residual(Goal, facetlog_compare, context(user, user, false), [], _), facetlog_unknown(Found), true),
    assertion(Found =@= What).
test(loop, Arity == 3) :-
    gensym(residual, Target),
    residual(each_of(_, X, upward(X), all, user, state, sum(holds, none), _), facetlog_say,
             context(user, Target, false), [], Code),
    forget_code(Target),
    functor(Code, _, Arity).
% A sum before a loop, and what it is like afterwards.
shape(sum(holds, none), sum(_, none)).
shape(sum(_, degree(1, 1, 0)), sum(_, degree(_, _, _))).
shape(sum(holds, degree(1, 1, left(1, []))), sum(_, degree(_, _, left(_, _)))).
shape([], _).
shape(_, _).

test(sum_has_the_shape_of_that_before, forall(( shape(Sum0, Expected), member(Goal, [each_of(_, _, _, _, _, _, Sum0, Sum),
                                                                                    each_test(_, _, _, _, Sum0, Sum)]) ))) :-
    copy_term(Sum0, Before),
    shaped(Goal),
    assertion(Sum0-Sum =@= Before-Expected).
test(verdicts, throws(facetlog_general(is_a(t, m)))) :-
    residual(model_said(state, t, m, _), facetlog_say, context(user, user, false), [], _).

:- end_tests(goals).

:- begin_tests(tests).

% What is left of a test, where the rules have a word; with the clauses that were made for it.
left_of(Test, Want, Crisp, Said, Code, Clauses) :-
    gensym(residual, Rules),
    gensym(residual, Target),
    setup_call_cleanup(
        ( new_rule_module(Rules), new_rule_module(Target),
          assertz(Rules:means(either(X, Y), any([upward(X), measured(Y)]))),
          assertz(Rules:means(bent(f, _), upward(f))) ),
        ( said_code(Test, Want, context(Rules, Target, Crisp), Said, Code),
          findall(Head-Body,
                  ( facetlog_target:made(Target, _, Arity, Name, _), functor(Head, Name, Arity),
                    clause(Target:Head, Body) ),
                  Clauses) ),
        ( forget_code(Target), '$destroy_module'(Target), '$destroy_module'(Rules) )).

state_left(Test, State, Code) :-
    left_of(Test, state, false, said(State, none), Code, []).

upward(A, S, ( upward(A) -> S = holds ; tilt(A, _, _) -> S = fails ; S = unknown )).

test(comparison, Code =@= ( fill(A, V, _), D is V - 0.5 -> ( D < 0 -> S = fails ; S = holds ) ; S = unknown )) :-
    left_of(at_least(fill(A), 0.5), state, true, said(S, none), Code, []).
test(relation, Code =@= Expected) :-
    state_left(upward(A), S, Code),
    upward(A, S, Expected).
test(known_parts, S-Code == fails-true) :-
    state_left(all([upward(_), any([]), upward(_)]), S, Code).
dear(each(X, [a, b, c], adjoins(X, f))).

test(alternatives_the_cheapest_first, Code =@= Expected) :-
    dear(Dear),
    state_left(any([Dear, whole(t)]), _, Code),
    state_left(any([whole(t), Dear]), _, Expected).
test(in_the_order_of_the_test_where_degrees_are_multiplied) :-
    dear(Dear),
    left_of(all([Dear, whole(t)]), full, false, _, Code, _),
    left_of(all([whole(t), Dear]), full, false, _, Other, _),
    assertion(Code \=@= Other).

% What code calls, with `made` for the name of the predicate that was made.
named(Name, Goal0, Goal) :-
    (   var(Goal0)
    ->  Goal = Goal0
    ;   Goal0 =.. [Name0|Args0],
        maplist(named(Name), Args0, Args),
        ( Name0 == Name -> Goal =.. [made|Args] ; Goal =.. [Name0|Args] )
    ).

test(loop, Code-Clauses =@= made(Fs, holds, S)-[made([], Sum, Sum)-true, made([X|Xs], S0, S1)-Step]) :-
    left_of(each(Y, Fs, upward(Y)), state, false, said(S, none), Code0, Clauses0),
    functor(Code0, Name, _),
    named(Name, Code0-Clauses0, Code-Clauses),
    upward(X, S2, One),
    Both = ( S0 == holds -> S2 = S3 ; S2 == holds -> S0 = S3 ; S0 == S2 -> S3 = S0 ; S3 = fails ),
    Step = ( S0 == fails -> S1 = S0 ; One, Both, made(Xs, S3, S1) ).
test(word_is_worked_out_once_for_what_it_is_asked_of, forall(member(Tests-Count, [ [either(A, B), either(B, A)]-2,
                                                                                   [either(f, A), either(f, B)]-1,
                                                                                   [bent(f, A), bent(f, B)]-1 ]))) :-
    left_of(all(Tests), state, false, said(_, none), Code, Clauses),
    Code = ( First, _ ),
    functor(First, Name, Arity),
    assertion(Arity =:= Count + 1),
    findall(Head, ( member(Head-_, Clauses), functor(Head, Name, Arity) ), Heads),
    length(Clauses, All),
    assertion(same_length(Heads, Clauses)),
    assertion(All =:= 2).
test(left_to_the_interpreter, forall(member(Test, [_, bent(_, f)]))) :-
    state_left(Test, S, facetlog_say:said(Test1, _, state, said(S1, none))),
    assertion(S1 == S),
    assertion(Test1 == Test).
test(what_another_model_says, throws(facetlog_general(is_a(_, m)))) :-
    state_left(all([upward(_), is_a(_, m)]), _, _).
test(what_another_model_says_within_a_test_that_is_not_known, throws(facetlog_general(is_a(_, m)))) :-
    state_left(_:[f, g(is_a(_, m))], _, _).

:- end_tests(tests).
