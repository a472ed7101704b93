% The vocabulary and the judge on facts written by hand.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(prove)).

:- dynamic scene_now/1.

with(Facts) :-
    gensym(test_scene, Scene),
    new_scene(Scene),
    forall(member(Fact, Facts), assertz(Scene:Fact)),
    asserta(scene_now(Scene)).

without :-
    retract(scene_now(Scene)),
    destroy_scene(Scene).

state(Test, State) :-
    state(Test, State, _, _).

state(Test, State, Low, High) :-
    scene_now(Scene),
    in_scene(Scene, evaluate(Test, user, proof(State, Low, High, _, _, _))).

tolerance(own, 7).
means(squarish(A, B), near(angle(A, B), 90, tolerance(own))).

:- begin_tests(tests, [ setup(with([ scale(unknown), thing(t1), face(f1), face(f2), face(f3),
                                     evidence(f1, measured), evidence(f2, measured),
                                     evidence(f3, implied),
                                     part_of(f1, t1), part_of(f2, t1), part_of(f3, t1),
                                     angle(f1, f2, 95.0, 1.0), angle(f2, f1, 95.0, 1.0),
                                     angle(f1, f3, 100.0, 60.0), area(f1, 2.0, 0.0),
                                     length(f1, 3.0, 0.1), width(f1, 1.0, 0.1),
                                     gap(t1, t2, 0.5, 0.01),
                                     convex(f1, f2), concave(f2, f3) ])),
                        cleanup(without) ]).

test(value_inside_holds, State == holds) :-
    state(near(angle(f1, f2), 90, 15), State).
test(value_outside_fails, State == fails) :-
    state(near(angle(f1, f2), 90, 4), State).
test(edge_of_a_region_belongs_to_it, S-L == holds-1.0) :-
    state(at_least(area(f1), area(f1)), S, L, _).
test(value_at_the_limit_is_half_probable, true(abs(Low - 0.5) < 1.0e-9)) :-
    state(at_most(angle(f1, f2), 95.0), _, Low, _).
test(hopeless_deviation_is_unknown, State == unknown) :-
    state(near(angle(f1, f3), 90, 15), State).
test(absent_fact_is_unknown, S-L-H == unknown-0-1) :-
    state(at_most(tilt(f1), 10), S, L, H).
test(unseen_part_is_unknown, State == unknown) :-
    state(convex(f1, unseen), State).
test(concave_is_not_convex, State == fails) :-
    state(convex(f2, f3), State).
test(neither_told_is_unknown, State == unknown) :-
    state(convex(f1, f3), State).
test(metres_are_unknown_without_scale, State == unknown) :-
    state(at_least(length(f1), metres(1.0)), State).
test(lengths_compare_without_scale, State == holds) :-
    state(at_least(length(f1), 2*width(f1)), State).
test(gaps_are_lengths, [S-T-U == holds-fails-unknown]) :-
    state(at_most(gap(t1, t2), 0.2*length(f1)), S),
    state(at_most(gap(t1, t2), 0.4*width(f1)), T),
    state(at_most(gap(t1, t3), length(f1)), U).
test(length_against_bare_number_is_an_error, error(type_error(comparable, _))) :-
    state(at_least(length(f1), 1), _).
test(unknown_word_is_an_error, error(existence_error(word, wobbly/1))) :-
    state(wobbly(f1), _).
test(own_words_and_tolerances, State == holds) :-
    state(squarish(f1, f2), State).
test(if_known_passes_what_is_unknown, S-L == holds-1) :-
    state(if_known(level(f1)), S, L, _).
test(expectation_lowers_only_the_degree, S-L == holds-0.75) :-
    state(expect(0.25, at_most(area(f1), 0)), S, L, _).
test(kleene_unknown_and_false_is_false, State == fails) :-
    state(all([level(f1), not(measured(f1))]), State).
test(kleene_unknown_or_true_is_true, State == holds) :-
    state(any([level(f1), measured(f1)]), State).
test(nothing_asked_of_nothing_holds, State == holds) :-
    state(each(X, [], level(X)), State).
test(too_few_seen_is_unknown, State == unknown) :-
    state(at_least(count([f1]), 3), State).
test(pairs_are_unordered, N == 3) :-
    scene_now(Scene),
    in_scene(Scene, evaluate(each_pair(X, Y, [f1, f2, f3], not(coplanar(X, Y))), user,
                             proof(holds, _, _, _, _, Children))),
    length(Children, N).
test(implied_faces_are_no_evidence, all(F == [f1, f2])) :-
    scene_now(Scene),
    in_scene(Scene, vocabulary:face_of(t1, F)).

:- end_tests(tests).

:- begin_tests(scene).

test(dropped_scene_leaves_no_module) :-
    gensym(test_scene, Scene),
    new_scene(Scene),
    assertz(Scene:face(f1)),
    destroy_scene(Scene),
    \+ current_module(Scene).

:- end_tests(scene).
