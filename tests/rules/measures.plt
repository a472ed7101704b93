% Measures and relations of faces, edges and things, on facts written by hand.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(prove)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog(vocabulary)).

:- dynamic scene_now/1.

with(Facts) :-
    gensym(measures_scene, Scene),
    new_scene(Scene),
    forall(member(Fact, Facts), assertz(Scene:Fact)),
    asserta(scene_now(Scene)).

without :-
    retract(scene_now(Scene)),
    destroy_scene(Scene).

state(Test, State) :-
    scene_now(Scene),
    in_scene(Scene, evaluate(Test, user, proof(State, _, _, _, _, _))).

% Value and deviation, to six digits.
of(Measure, Value-Sd) :-
    scene_now(Scene),
    in_scene(Scene, value(Measure, user, quantity(V, Var, _))),
    Value is round(V*1000000)/1000000.0,
    Sd is round(sqrt(Var)*1000000)/1000000.0.

missing(Test, Missing-Cause) :-
    scene_now(Scene),
    in_scene(Scene, evaluate(Test, user, proof(unknown, _, _, _, missing(Missing, Cause), _))).

found(Goal, Template, Found) :-
    scene_now(Scene),
    findall(Template, in_scene(Scene, Goal), Found).

tolerance(half, 0.5).

% A board f1 with its underside f2 on a leg f3 and a loose edge e9; f5 and f6 rise above it, f5 at its rim;
% things t1, t2 and t3 in a row.
board([ scale(unknown), up(0.0, 0.0, 1.0), thing(t1), thing(t2), thing(t3),
        thing_size(t1, 3.0, 2.0, 1.0),
        face(f1), face(f2), face(f3), face(f4),
        evidence(f1, measured), evidence(f2, measured), evidence(f3, measured),
        evidence(f4, implied), evidence(e9, measured),
        part_of(f1, t1), part_of(f2, t1), part_of(f3, t1), part_of(f4, t1), part_of(e9, t1),
        area(f1, 6.0, 0.3), area(f2, 5.0, 0.4), area(f3, 1.0, 0.0), area(f4, 9.0, 0.0),
        length(f1, 3.0, 0.1), width(f1, 2.0, 0.1),
        elevation(f1, 1.0, 0.01), elevation(f2, 0.9, 0.01),
        tilt(f3, 90.0, 1.0), opposite(f1, f2), opposite(f2, f1),
        top_of(f1, 1.0, 0.01), top_of(f3, 0.9, 0.03), bottom_of(f3, 0.0, 0.04),
        tilt(f1, 0.0, 0.5), tilt(f5, 90.0, 1.0), tilt(f6, 90.0, 1.0), at_rim(f5, f1),
        top_of(f5, 1.6, 0.01), bottom_of(f5, 0.0, 0.01),
        top_of(f6, 1.6, 0.01), bottom_of(f6, 0.0, 0.01),
        edge(e9, v1, v2), point(v1, 0.0, 0.0, 0.0), point(v2, 0.0, 0.0, 0.95),
        top_of(e9, 0.95, 0.01), bottom_of(e9, 0.0, 0.01),
        edge(e1, v3, v4), bounds(e1, f1),
        vertex(v1), vertex(v2),
        corner(f1, 1, v1), corner(f1, 2, v2), corner(f1, 3, v3), corner(f3, 1, v1),
        corner(f4, 1, v1),
        adjoins(f1, f3, e1), adjoins(f1, f3, e2), adjoins(f3, f1, e1), adjoins(f3, f1, e2),
        edge_length(e1, 0.5, 0.01), edge_length(e2, 0.7, 0.02),
        gap(t1, t2, 0.02, 0.01), gap(t2, t1, 0.02, 0.01),
        gap(t2, t3, 0.4, 0.01), gap(t3, t2, 0.4, 0.01),
        gap(t1, t3, 1.5, 0.02), gap(t3, t1, 1.5, 0.02) ]).

:- begin_tests(measures, [ setup(( board(Facts), with(Facts) )), cleanup(without) ]).

test(longest_shared_edge, V == 0.7-0.02) :-
    of(shared_length(f1, f3), V).
test(no_shared_edge_has_no_length, M == shared_length(f1, f2)-unstated) :-
    missing(at_least(shared_length(f1, f2), width(f1)), M).
test(shared_lengths_are_found_for_pairs, all(A-B == [f1-f3, f3-f1])) :-
    scene_now(Scene),
    in_scene(Scene, measure(shared_length(A, B), _, _, _)).
test(corners_of_an_outline, V == 3.0-0.0) :-
    of(corners(f1), V).
test(measured_faces_at_a_vertex, V-W == (2.0-0.0)-(1.0-0.0)) :-
    of(faces_at(v1), V),
    of(faces_at(v2), W).
test(too_few_faces_at_a_vertex_are_unknown, S-T == unknown-fails) :-
    state(at_least(faces_at(v1), 3), S),
    state(at_most(faces_at(v1), 1), T).
test(height_of_a_face_is_from_bottom_to_top, V == 0.9-0.05) :-
    of(height(f3), V).
test(height_of_an_edge, V == 0.95-0.014142) :-
    of(height(e9), V).
test(sizes_of_a_thing, V == [3.0-0.0, 2.0-0.0, 1.0-0.01, 0.5-0.005]) :-
    of(length(t1), L), of(width(t1), W), of(height(t1), H), of(elevation(t1), E),
    V = [L, W, H, E].
test(area_of_a_thing_is_that_of_its_measured_faces, V == 12.0-0.5) :-
    of(area(t1), V).
test(area_of_a_thing_without_faces_is_unknown, M == area(t3)-unstated) :-
    missing(at_least(area(t3), area(f1)), M).
test(lowest_and_highest, V-W == (5.0-0.4)-(6.0-0.3)) :-
    of(lowest([area(f1), area(f2)]), V),
    of(highest([area(f1), area(f2)]), W).
test(sum_and_mean_to_first_order, V-W == (11.0-0.5)-(5.5-0.25)) :-
    of(sum([area(f1), area(f2)]), V),
    of(mean([area(f1), area(f2)]), W).
test(summaries_of_expressions, V == 3.0-0.15) :-
    of(lowest([tolerance(half)*area(f1), 0.75*area(f1)]), V).
test(nothing_has_no_summary, M == lowest([])-unstated) :-
    missing(at_least(lowest([]), area(f1)), M).
test(one_that_is_unknown_makes_a_summary_unknown, M == area(f9)-unstated) :-
    missing(at_least(sum([area(f1), area(f9)]), area(f1)), M).
test(a_summary_of_lengths_and_areas_is_an_error, error(type_error(comparable, _))) :-
    state(at_least(sum([area(f1), length(f1)]), area(f1)), _).
test(gaps_between_things, V-W == (0.02-0.01)-(1.5-0.02)) :-
    of(smallest_gap([t1, t2, t3]), V),
    of(largest_gap([t1, t2, t3]), W).
test(one_thing_has_no_gap, M == smallest_gap([t1])-unstated) :-
    missing(at_most(smallest_gap([t1]), length(f1)), M).
test(an_unknown_gap_makes_all_unknown, State == unknown) :-
    state(at_most(smallest_gap([t1, t2, t9]), length(f1)), State).

test(supports_reach_from_the_ground_to_the_board, [S, T, U] == [holds, holds, fails]) :-
    state(supports(f3, f1), S),
    state(supports(e9, f1), T),
    state(not(supports(f3, f1)), U).
test(what_carries_a_board_at_its_rim_may_rise_above_it, [S, T] == [holds, fails]) :-
    state(supports(f5, f1), S),
    state(supports(f6, f1), T).
test(supports_of_what_is_not_known_are_unknown, State == unknown) :-
    state(supports(f9, f1), State).
test(standing_below_is_who_supports, X == [f3, e9]) :-
    found(standing_below(f1, S), S, X).
test(undersides_are_of_the_same_board, X == [[f1, f2]]) :-
    state(underside_of(f2, f1), holds),
    state(underside_of(f1, f2), fails),
    found(undersides(f1, U), U, X).
test(above_and_below, [S, T, U] == [holds, fails, unknown]) :-
    state(above(f1, f2), S),
    state(below(f1, f2), T),
    state(above(f1, f3), U).
test(an_edge_bounds_a_face, [S, T] == [holds, fails]) :-
    state(bounds(e1, f1), S),
    state(bounds(e1, f2), T).
test(things_touch_within_three_deviations, [S, T, U] == [holds, fails, unknown]) :-
    state(touches(t1, t2), S),
    state(touches(t2, t3), T),
    state(touches(t1, t9), U).
test(elements_are_measured_faces_and_loose_edges, X == [f1, f2, f3, e9]) :-
    found(element_of(t1, E), E, X).

:- end_tests(measures).

:- begin_tests(without_up, [ setup(with([thing(t1), face(f1), face(f2), area(f1, 1.0, 0.0)])),
                             cleanup(without) ]).

test(heights_need_up, M == height(f1)-up) :-
    missing(at_least(height(f1), 0.5*height(f2)), M).
test(above_needs_up, State == unknown) :-
    state(above(f1, f2), State).

:- end_tests(without_up).
