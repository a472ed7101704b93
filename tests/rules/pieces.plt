% Words for pieces on facts written by hand.
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
    state(Test, State, _).

state(Test, State, Low) :-
    scene_now(Scene),
    in_scene(Scene, evaluate(Test, user, proof(State, Low, _, _, _, _))).

value(Measure, V-Sd-Kind) :-
    scene_now(Scene),
    in_scene(Scene, measures:measure(Measure, V, Sd, Kind)).

found(Goal, X, Xs) :-
    scene_now(Scene),
    findall(X, in_scene(Scene, vocabulary:Goal), Xs).

%   p1 a top, p2 a leg, p3 a block, p4 between board and block, p5 without up.
facts([ scale(metric), up(0.0, 0.0, 1.0), thing(t1), thing(t2),
        piece(p1), piece_of(p1, t1), piece_size(p1, 1.2, 0.8, 0.04, 0.01),
        piece_heights(p1, 0.7, 0.74, 0.01), piece_tilt(p1, 1.0, 0.5),
        piece_round(p1, 0.0), piece_level(p1, free_below, 0.9, 0.02),
        piece_level(p1, room_below, 0.6, 0.02),
        piece(p2), piece_of(p2, t1), piece_size(p2, 0.7, 0.05, 0.05, 0.001),
        piece_heights(p2, 0.0, 0.7, 0.01), piece_tilt(p2, 89.0, 0.5), piece_on_ground(p2),
        piece_round(p2, 0.4), piece_measured(p2), piece_level(p1, shelves_below, 0.0, 0.0),
        piece_unseen(p1, shelves_below, 0.0, 2.0), piece_level(p3, shelves_below, 1.0, 0.0),
        face(f1), shelves_below(f1, 2), shelves_unseen(f1, 2, 3),
        piece(p3), piece_of(p3, t2), piece_size(p3, 0.3, 0.2, 0.15, 0.001),
        piece_heights(p3, 0.0, 0.2, 0.01), piece_tilt(p3, 0.0, 0.5),
        piece_side_tilt(p3, 0.0, 0.5),
        piece(p4), piece_of(p4, t2), piece_size(p4, 0.4, 0.2, 0.07, 0.0),
        piece(p5), piece_of(p5, t2), piece_size(p5, 0.4, 0.2, 0.01, 0.0),
        joins(p1, p2), joins(p2, p1), carries(p2, p1),
        piece_angle(p1, p2, 88.0, 1.0), piece_angle(p3, p4, 2.0, 1.0) ]).

with_pieces :- facts(Facts), with(Facts).

:- begin_tests(pieces, [ setup(with_pieces), cleanup(without) ]).

test(what_is_level_with_another_is_neither_above_nor_below, [S, T, U] == [holds, fails, fails]) :-
    state(piece_above(p1, p2), S),
    state(piece_above(p1, p1), T),
    state(piece_below(p1, p1), U).
test(shapes_exclude_one_another, Shapes == [p1-board, p2-bar, p3-block]) :-
    findall(P-Shape,
            ( member(P, [p1, p2, p3]),
              member(Shape, [board, bar, block]),
              Test =.. [Shape, P],
              state(Test, holds) ),
            Shapes).
test(a_shape_between_two_is_half_of_each, true(max(abs(L - 0.5), abs(B - 0.5)) < 1.0e-6)) :-
    state(board(p4), _, L),
    state(block(p4), _, B).
test(extents_are_those_of_the_box, Vs == [1.2, 0.8, 0.04]) :-
    findall(V, ( member(M, [piece_length(p1), piece_width(p1), thickness(p1)]),
                 value(M, V-0.01-length) ), Vs).
test(heights_are_above_the_lowest_point, true(max(abs(H - 0.04), abs(E - 0.72)) < 1.0e-9)) :-
    value(piece_height(p1), H-_-length),
    value(piece_elevation(p1), E-_-length).
test(ends, [T, B] == [0.74, 0.7]) :-
    value(piece_top_of(p1), T-_-_),
    value(piece_bottom_of(p1), B-_-_).
test(levels_have_the_kind_of_what_they_measure, [A, B] == [0.9-0.02-ratio, 0.6-0.02-length]) :-
    value(piece_free_below(p1), A),
    value(piece_room_below(p1), B).
test(a_measure_that_no_level_has_is_not_known, State == unknown) :-
    state(at_least(piece_cover(p1), 0.5), State).
test(shelves_are_counted_as_far_as_was_seen, [S, T, U, V] == [unknown, fails, holds, unknown]) :-
    state(at_least(piece_shelves_below(p1), 1), S),
    state(at_least(piece_shelves_below(p1), 3), T),
    state(at_most(piece_shelves_below(p1), 2), U),
    state(at_most(piece_shelves_below(p4), 2), V).
test(shelves_beneath_a_face, [S, T, U] == [holds, unknown, holds]) :-
    state(at_least(shelves_below(f1), 2), S),
    state(near(shelves_below(f1), 2, 0), T),
    state(near(piece_shelves_below(p3), 1, 0), U).
test(turned_to_one_another, [A, S, T, U] == [88.0-1.0-deg, holds, fails, unknown]) :-
    value(piece_angle(p1, p2), A),
    state(piece_parallel(p3, p4, 10), S),
    state(piece_parallel(p1, p2, 10), T),
    state(piece_parallel(p1, p3, 10), U).
test(seen, [S, T, U] == [holds, fails, unknown]) :-
    state(piece_measured(p2), S),
    state(piece_measured(p1), T),
    state(piece_measured(unseen), U).
test(curved_share, V == 0.4) :-
    value(piece_curved(p2), V-_-ratio).
test(how_they_lie, [S, T, U, V] == [holds, fails, fails, holds]) :-
    state(piece_level(p1), S),
    state(piece_upright(p1), T),
    state(piece_level(p2), U),
    state(piece_upright(p2), V).
test(joins_and_carries, [S, T, U, V] == [holds, fails, holds, fails]) :-
    state(joins(p1, p2), S),
    state(joins(p1, p3), T),
    state(carries(p2, p1), U),
    state(carries(p1, p2), V).
test(what_carries_is_not_known_without_heights, [S, T] == [unknown, unknown]) :-
    state(carries(p5, p1), S),
    state(piece_on_ground(p5), T).
test(nothing_is_known_of_what_was_not_seen, [S, T] == [unknown, unknown]) :-
    state(joins(unseen, p1), S),
    state(board(unseen), T).
test(on_the_ground, [S, T] == [holds, fails]) :-
    state(piece_on_ground(p2), S),
    state(piece_on_ground(p1), T).
test(above_and_below, [S, T] == [holds, fails]) :-
    state(piece_above(p1, p2), S),
    state(piece_below(p1, p2), T).
test(pieces_of_a_thing, Ps == [p1, p2]) :-
    found(piece_in(t1, P), P, Ps).
test(the_largest_first, Ps == [[p3, p4, p5]]) :-
    found(largest_pieces(t2, P), P, Ps).
test(choices_are_the_first_that_are_free, Ps == [p4, p5]) :-
    found(piece_choice([p3, p4, p5], 2, [p3], P), P, Ps).
test(only_what_fits_is_near_where_pieces_may_lack, Ps == [[p4]]) :-
    found(nearest_pieces(t2, [p3, p4, p5], [[p3, p4], [p4, p5]], P), P, Ps).
test(nothing_left_is_unseen, Ps == [unseen]) :-
    found(piece_choice([p3], 2, [p3], P), P, Ps).

:- end_tests(pieces).
