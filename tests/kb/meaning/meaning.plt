% What random tests do not show: errors, what is not asked any more, and what only a proof says.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(say)).
:- use_module(facetlog_kb(prove)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(left_open)).

:- dynamic scene_now/1.

with(Facts) :-
    facetlog_bridge:ask_base(nobody, all),
    gensym(meaning_scene, Scene),
    new_scene(Scene),
    forall(member(Fact, Facts), assertz(Scene:Fact)),
    asserta(scene_now(Scene)).

without :-
    retract(scene_now(Scene)),
    destroy_scene(Scene).

facts([ thing(t1), face(f1), face(f2), evidence(f1, measured), evidence(f2, measured),
        angle(f1, f2, 90.0, 1.0), tilt(f1, 20.0, 0.0), tilt(f2, 30.0, 2.0),
        width(f1, 1.0, 0.1), length(f1, 2.0, 0.0), area(f1, 2.0, 0.0), fill(f1, 0.5, 0.0) ]).

in_facts(Goal) :-
    facts(Facts),
    setup_call_cleanup(with(Facts), ( scene_now(Scene), in_scene(Scene, Goal) ), without).

outline_of(Test, Outline) :-
    in_facts(outline(Test, user, Outline)).

state_of(Test, State) :-
    in_facts(state(Test, user, State)).

% The error of every way in which a test is judged, one and the same.
error_of(Test, Formal) :-
    in_facts(( formal(outline(Test, user, _), Formal),
               formal(state(Test, user, _), Formal1),
               formal(evaluate(Test, user, _), Formal2) )),
    assertion(Formal1 =@= Formal),
    assertion(Formal2 =@= Formal).

formal(Goal, Formal) :-
    catch(( Goal, Formal = none ), error(Formal, _), true).

detail_of(Test, Detail) :-
    in_facts(evaluate(Test, user, proof(_, _, _, _, Detail, _))).

product_of(Times, N, Product) :-
    (   Times =:= 1
    ->  Product = N
    ;   Less is Times - 1,
        Product = Product0*N,
        product_of(Less, N, Product0)
    ).

% A word that counts how often its meaning is looked up.
means(counted(Test), Test) :- flag(asked, N, N + 1).
means(either, all([])).
means(either, any([])).
means(level(none), any([])).
tolerance(spelt, ten).
tolerance(own, 25).
tolerance(twice, 3).
tolerance(twice, 4).
measured(large, V, 0, count) :- V is 10**30.
measured(too_large, V, 0, count) :- V is 10**400.
measured(no_number, many, 0, deg).
measured(no_deviation, 2, -1, deg).
measured(no_kind, 2, 1, weight).
measured(fill(_), 7, 0, deg).           % what the vocabulary knows is that
measured(times, 3, 0.5, ratio).
measured(times, 4, 0.5, ratio).

:- begin_tests(errors).

test(unbound_test, Formal =@= instantiation_error) :-
    error_of(_, Formal).
test(word_that_is_not_there, Formal == existence_error(word, nosuch/2)) :-
    error_of(nosuch(f1, f2), Formal).
test(slope_of_a_slope, forall(( member(Test, [fading(Inner, 1), soft(Inner, 0.1)]),
                                member(Inner, [fading(at_most(tilt(f1), 3), 1), soft(at_most(tilt(f1), 3), 0.1)]) ))) :-
    functor(Test, Name, 2),
    error_of(Test, Formal),
    assertion(Formal == existence_error(word, Name/2)).
test(limits_that_fade_of_no_test, Formal == existence_error(word, fading/2)) :-
    error_of(fading(_, 1), Formal).
test(weight_that_is_no_number, Formal == type_error(number, 1/2)) :-
    error_of(expect(1/2, all([])), Formal).
test(weight_above_one, Formal == type_error(between(0.0, 1.0), 2)) :-
    error_of(expect(2, all([])), Formal).
test(weight_below_zero, Formal = type_error(between(_, _), -1)) :-
    error_of(expect(-1, all([])), Formal).
test(share_that_is_none, forall(member(Share-Error, [ 1/2-type_error(number, 1/2), 1.5-type_error(between(0.0, 1.0), 1.5),
                                                     -1-type_error(between(0.0, 1.0), -1) ]))) :-
    error_of(soft(at_most(tilt(f1), 3), Share), Formal),
    assertion(Formal == Error).
test(measure_that_is_none, forall(member(Measure-Error, [ no_number-type_error(number, many),
                                                          no_deviation-domain_error(standard_deviation, -1),
                                                          no_kind-type_error(oneof(_), weight) ]))) :-
    error_of(at_most(Measure, 3), Formal),
    assertion(Formal = Error).
test(value_beyond_all_floats, Formal = domain_error(finite_number, _)) :-
    error_of(at_most(too_large, 3), Formal).
test(count_below_zero, Formal == type_error(nonneg, -1)) :-
    error_of(at_least_of(-1, X, [[f1]], measured(X)), Formal).
test(most_below_zero, Formal == type_error(nonneg, -1)) :-
    error_of(at_most_of(-1, X, [[f1]], measured(X)), Formal).
test(count_that_is_no_number, Formal == type_error(nonneg, many)) :-
    error_of(at_most_of(many, X, [[f1]], measured(X)), Formal).
test(groups_that_are_none, Formal == type_error(list, f1)) :-
    error_of(at_least_of(1, X, [f1], measured(X)), Formal).
test(model_that_is_no_name, Formal == type_error(atom, 3)) :-
    error_of(is_a(t1, 3), Formal).
test(model_that_is_not_there, Formal == existence_error(model, nosuch)) :-
    error_of(is_a(t1, nosuch), Formal).
test(tolerance_without_number, Formal == type_error(number, ten)) :-
    error_of(at_most(tilt(f1), tolerance(spelt)), Formal).
test(tolerance_that_is_not_there, Formal == existence_error(tolerance, nosuch)) :-
    error_of(at_most(tilt(f1), tolerance(nosuch)), Formal).
test(kinds_that_do_not_compare, forall(member(Test, [ at_least(width(f1), 1),
                                                      at_least(fill(f1), width(f1)),
                                                      at_most(tilt(f1), area(f1)),
                                                      at_most(area(f1), width(f1)),
                                                      at_most(width(f1)*area(f1), area(f1)),
                                                      near(width(f1), 1, width(f1)),
                                                      near(width(f1), width(f1), 1),
                                                      between(width(f1), 1, width(f1)),
                                                      between(width(f1), width(f1), 1),
                                                      fading(at_least(width(f1), width(f1)), 1) ]))) :-
    error_of(Test, Formal),
    assertion(Formal == type_error(comparable, Test)).
test(terms_that_do_not_add, forall(member(Expression, [ width(f1) + fill(f1), width(f1) - area(f1),
                                                        lowest([width(f1), tilt(f1)]),
                                                        highest([area(f1), width(f1), fill(f1)]),
                                                        sum([tilt(f1), width(f1)]),
                                                        mean([tilt(f1), tilt(f1), area(f1)]) ]))) :-
    error_of(at_least(Expression, 0), Formal),
    assertion(Formal == type_error(comparable, Expression)).
test(nothing_compares_with_all, forall(member(Test, [ at_least(width(f1), 0), at_most(area(f1), 3*0),
                                                      at_least(width(f1) + 0, 0) ]))) :-
    error_of(Test, none).

test(numbers_that_grow_too_long, Formal == resource_error(number_length)) :-
    N is 2**1000,
    product_of(70, N, Long),
    error_of(at_least(Long, 1), Formal).

:- end_tests(errors).

:- begin_tests(words).

test(first_meaning_counts, Tests == [all([])]) :-
    findall(Test, meaning(either, user, Test), Tests).
test(meaning_of_the_rules_before_that_of_the_vocabulary, Tests == [any([])]) :-
    findall(Test, meaning(level(none), user, Test), Tests).
test(meaning_of_the_vocabulary, Tests == [at_most(tilt(f1), 10)]) :-
    findall(Test, meaning(level(f1), user, Test), Tests).
test(no_name_beside_its_variable, State == holds) :-
    state_of(each(X, [], X), State).
test(other_variables_stay_what_they_are, Test-Y == near(angle(f1, Y), Z, 3)-Y) :-
    instance([X], near(angle(X, Y), Z, 3), [f1], Test).
test(what_is_static_is_so_once, Xs == [1]) :-
    findall(X, facetlog_static:static(member(X, [1, 2])), Xs).
test(pattern_of_an_object_and_its_parts, Test == adjoins(f1, f2)) :-
    instance([p(X, Y)], adjoins(X, Y), [p(f1, f2)], Test).
test(first_tolerance_counts, Values == [3]) :-
    findall(Value, facetlog_quantities:named_tolerance(twice, user, Value), Values).

:- end_tests(words).

:- begin_tests(questions).

% How often the word `counted` is asked within what is judged.
asked(Goal, Count) :-
    flag(asked, _, 0),
    in_facts(Goal),
    flag(asked, Count, Count).

% Of these the state, or all, is known before the rest is asked.
settled(any([all([]), counted(all([]))]), state, 0).
settled(all([any([]), counted(all([]))]), state, 0).
settled(any([any([]), counted(all([]))]), state, 1).
settled(all([all([]), counted(all([]))]), state, 1).
settled(all([near(tilt(f2), 31, 3), counted(all([]))]), state, 1).
settled(expect(0.5, counted(all([]))), state, 0).
settled(expect(0.5, counted(all([]))), full, 1).
settled(any([all([]), counted(all([]))]), full, 0).
settled(any([at_least(tilt(f2), 27), counted(all([]))]), full, 1).
settled(any([at_least(tilt(f2), 27), counted(all([]))]), state, 0).
settled(all([any([]), counted(all([]))]), full, 0).
settled(all([at_least(tilt(f2), 31), counted(all([]))]), full, 1).
settled(all([at_least(tilt(f2), 31), counted(all([]))]), state, 0).
settled(all([at_least(tilt(f1), 31), counted(all([]))]), full, 1).
settled(all([at_most(tilt(f1), 0.001), counted(all([]))]), full, 1).
settled(each(X, [f1, f2, f2], counted(convex(X, unseen))), state, 3).
settled(each(X, [f1, f2, f2], counted(adjoins(X, f1))), state, 1).
settled(some(X, [f1, f2, f2], counted(measured(X))), state, 1).
settled(each_pair(X, Y, [f1, f2, f2], counted(adjoins(X, Y))), state, 1).
settled(each_pair(X, Y, [f1, f2, f1], counted(all([measured(X), measured(Y)]))), state, 3).
settled(at_least_of(1, X, [[f1, f2], [f2]], counted(measured(X))), state, 2).
settled(at_most_of(1, X, [[f1, f2], [f2]], counted(adjoins(X, f1))), full, 3).
settled(implies(adjoins(f1, f2), counted(all([]))), state, 0).
settled(implies(measured(f1), counted(all([]))), state, 1).

test(what_settles_a_test, forall(settled(Test, Want, Count))) :-
    asked(said(Test, user, Want, _), Asked),
    assertion(Test-Asked == Test-Count).
test(state_asks_less_than_the_outline, Asked-All == 0-1) :-
    Test = any([at_least(tilt(f2), 27), counted(all([]))]),
    asked(state(Test, user, _), Asked),
    asked(outline(Test, user, _), All).
test(proof_has_all_parts, Asked == 2) :-
    asked(evaluate(any([counted(all([])), counted(all([]))]), user, _), Asked).

:- end_tests(questions).

:- begin_tests(proofs).

test(nearer_edge, Margin = margin(above, _, _)) :-
    detail_of(between(tilt(f1), 5, 25), compared(_, _, deg, between(5, 25), Margin)).
test(of_two_edges_as_near_the_lower, Margin == margin(below, 10.0, 0.0)) :-
    detail_of(near(tilt(f1), 20, 10), compared(_, _, _, _, Margin)).
test(margin_has_the_deviation_of_both, true(abs(Sd - sqrt(5)) < 1.0e-12)) :-
    detail_of(at_least(tilt(f2), angle(f1, f2)), compared(_, 2.0, deg, _, margin(below, -60.0, Sd))).
test(margin_from_the_middle_of_a_slope, Margin == margin(above, 3.0, 0.0)) :-
    detail_of(fading(at_most(tilt(f1), 18), 10), compared(_, _, _, fading(at_most(18), 10), Margin)).
test(what_cannot_be_told, Detail == uncertain(90.0, 1.0, deg, near(90, 0.5), margin(below, 0.5, 1.0))) :-
    detail_of(near(angle(f1, f2), 90, 0.5), Detail).
test(margin_has_the_deviation_of_half_a_slope, forall(member(Test-Sd, [ at_most(tilt(f1), 18)-1.0,
                                                                       near(tilt(f1), 25, 4)-1.0,
                                                                       near(tilt(f1), 15, 4)-1.0 ]))) :-
    detail_of(fading(Test, 2*angle(f1, f2)), compared(_, _, _, _, margin(_, _, Found))),
    assertion(Found =:= Sd).
test(kinds, Kinds == [deg, ratio, length, area, power(3), power(-1), length, length, ratio, count, ratio, number]) :-
    findall(Kind,
            ( member(M, [tilt(f1), fill(f1), length(f1), width(f1)*length(f1), area(f1)*length(f1),
                         length(f1)/area(f1), area(f1)/length(f1), fill(f1)*length(f1), width(f1)/length(f1),
                         count([f1]), times, 3]),
              in_facts(value(M, user, quantity(_, _, Kind))) ),
            Kinds).
test(missing_operand, forall(member(Expression, [ -tilt(f3), tilt(f1) + tilt(f3), tilt(f3) + tilt(f4),
                                                  tilt(f1) - tilt(f3), 2*tilt(f3), tilt(f1)/tilt(f3),
                                                  lowest([tilt(f1), tilt(f3), tilt(f4)]),
                                                  highest([tilt(f3)]), sum([tilt(f1), tilt(f3)]),
                                                  mean([tilt(f3), tilt(f1)]) ]))) :-
    detail_of(at_least(Expression, 1), missing(Missing, Cause)),
    assertion(Missing-Cause == tilt(f3)-up).
test(missing_whole, forall(member(Expression, [tilt(f1)/0, lowest([]), mean(f1), lowest(_), highest(_), sum(_), lowest([tilt(f1)|_]),
                                                   mean(_)]))) :-
    detail_of(at_least(Expression, 1), missing(Missing, _)),
    assertion(Missing =@= Expression).
test(missing_limit, Missing == area(f2)) :-
    detail_of(near(area(f1), area(f2), area(f3)), missing(Missing, _)).

:- end_tests(proofs).

:- begin_tests(quantities).

test(own_tolerance_before_that_of_the_vocabulary, State == holds) :-
    state_of(at_most(tilt(f1), tolerance(own)), State).
test(tolerance_of_the_vocabulary, State == fails) :-
    state_of(at_most(tilt(f1), tolerance(level)), State).
test(measure_of_the_vocabulary_before_one_of_the_rules, Q == quantity(0.5, 0.0, ratio)) :-
    in_facts(value(fill(f1), user, Q)).
test(first_own_measure_counts, Found == [3.0-0.25-ratio]) :-
    findall(V-Var-Kind, in_facts(value(times, user, quantity(V, Var, Kind))), Found).
test(what_is_no_expression, forall(member(Measure, [_, "text"]))) :-
    state_of(at_least(Measure, 1), State),
    assertion(State == unknown).
test(more_may_be_there_than_was_seen, Outline == outline(unknown, 0, 1, 0)) :-
    outline_of(at_least(count([f1]), 3), Outline).
test(longest_first, Sorted == [length(f1), width(f1)]) :-
    in_facts(longest_first_in(user, [width(f1), length(f1)], Sorted)).
test(longest_of_unknown_ones, fail) :-
    in_facts(longest_first_in(user, [width(f1), length(f2)], _)).
test(spread_of_a_quotient, true(abs(Var - 0.0025) < 1.0e-12)) :-
    in_facts(value(width(f1)/length(f1), user, quantity(0.5, Var, ratio))).
test(of_lists, forall(member(Expression-V-Var, [ lowest([tilt(f2), tilt(f1)])-20.0-0.0, highest([tilt(f1), tilt(f2)])-30.0-4.0,
                                                  sum([tilt(f1), tilt(f2), tilt(f2)])-80.0-8.0,
                                                  mean([tilt(f1), tilt(f2)])-25.0-1.0 ]))) :-
    in_facts(value(Expression, user, Q)),
    assertion(Q == quantity(V, Var, deg)).
test(of_as_low_ones_the_surest, Q == quantity(20.0, 0.0, deg)) :-
    in_facts(value(lowest([tilt(f1), tilt(f1) + 0*tilt(f2)]), user, Q)).

:- end_tests(quantities).

:- begin_tests(slopes).

low(Test, Low) :-
    outline_of(Test, outline(_, Low, Low, _)).

% In the middle of a slope half; beyond it all or nothing; between, so much of the way.
test(on_an_exact_slope, forall(member(Limit-Low, [ 20-1.0, 22-0.8, 25-0.5, 28-0.2, 30-0.0, 40-0.0 ]))) :-
    low(fading(at_least(tilt(f1), Limit), 10), Found),
    assertion(abs(Found - Low) < 1.0e-9).
% A slope is many edges: the mean of their degrees.
test(slope_of_a_spread_value, forall(member(Limit, [10, 20, 25, 28, 29, 30, 31, 34, 40, 50]))) :-
    low(fading(at_least(tilt(f2), Limit), 5), Found),
    findall(Low, ( between(0, 49, N), Edge is Limit - 0.1*N - 0.05, low(at_least(tilt(f2), Edge), Low) ), Lows),
    sum_list(Lows, Sum),
    assertion(abs(Found - Sum/50) < 1.0e-3).
test(between_two_slopes, forall(member(Low-High-Degree, [ 22-25-0.6, 10-18-0.6, 25-30-0.0, 15-25-1.0 ]))) :-
    low(fading(between(tilt(f1), Low, High), 5), Found),
    assertion(abs(Found - Degree) < 1.0e-9).
test(slope_far_away_is_certain, Lows == [1.0, 0.0]) :-
    low(fading(at_least(angle(f1, f2), 20), 10), Certain),
    low(fading(at_most(angle(f1, f2), 20), 10), Never),
    Lows = [Certain, Never].
test(negative_width_is_none, Low == 1.0) :-
    low(fading(at_least(tilt(f1), 20), -5), Low).
test(narrow_slope_is_an_edge, true(abs(Narrow - Sharp) < 1.0e-9)) :-
    low(at_least(tilt(f2), 31), Sharp),
    low(fading(at_least(tilt(f2), 31), 1.0e-9), Narrow).
test(slope_adds_half_its_width_to_the_tolerance, true(abs(Miss - 15/(15 + 45)) < 1.0e-9)) :-
    outline_of(fading(at_least(tilt(f1), 40), 10), outline(fails, _, _, Miss)).
test(almost_whole_miss_is_not_whole, true(abs(Miss - 19.999/20) < 1.0e-9)) :-
    outline_of(all([at_most(tilt(f1), 0.001)]), outline(fails, _, _, Miss)).
test(miss_without_tolerance_is_whole, true(Miss =:= 1)) :-
    outline_of(at_most(tilt(f1), 0), outline(fails, _, _, Miss)).

:- end_tests(slopes).
