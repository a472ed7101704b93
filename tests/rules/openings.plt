% Words for openings, and what hangs, on facts written by hand.
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
    scene_now(Scene),
    in_scene(Scene, evaluate(Test, user, proof(State, _, _, _, _, _))).

value(Measure, V-Sd-Kind) :-
    scene_now(Scene),
    in_scene(Scene, measures:measure(Measure, V, Sd, Kind)).

found(Goal, X, Xs) :-
    scene_now(Scene),
    findall(X, in_scene(Scene, vocabulary:Goal), Xs).

%   o1 a door's, o2 above it, o3 without up; p1 a lintel, from which p2 hangs.
facts([ up(0.0, 0.0, 1.0), thing(t1), face(f1), evidence(f1, measured), part_of(f1, t1),
        opening(o1), opening_of(o1, t1), opening_size(o1, 2.0, 0.8, 0.01),
        opening_heights(o1, 0.1, 2.1, 0.01), opening_in(o1, f1),
        opening(o2), opening_of(o2, t1), opening_size(o2, 0.8, 0.3, 0.01),
        opening_heights(o2, 2.2, 2.5, 0.01),
        opening(o3), opening_of(o3, t2), opening_size(o3, 0.8, 0.3, 0.01),
        piece(p1), piece_heights(p1, 2.1, 2.2, 0.01),
        piece(p2), piece_heights(p2, 1.8, 2.1, 0.01),
        piece(p3),
        frames(p1, o1), joins(p1, p2), joins(p2, p1), hangs_from(p2, p1), opening_in(o1, p1),
        inside(p2, o1, yes), inside(o1, p2, no), beside(p3, o2, yes), beside(p1, o1, no),
        thing(t2), openings_known(t2) ]).

with_openings :- facts(Facts), with(Facts).

:- begin_tests(openings, [ setup(with_openings), cleanup(without) ]).

test(extents, [L, W] == [2.0-0.01-length, 0.8-0.01-length]) :-
    value(opening_length(o1), L),
    value(opening_width(o1), W).
test(heights, true(max(abs(H - 2.0), abs(E - 1.1)) < 1.0e-9)) :-
    value(opening_height(o1), H-_-length),
    value(opening_elevation(o1), E-_-length).
test(ends, [T, B] == [2.1, 0.1]) :-
    value(opening_top_of(o1), T-_-_),
    value(opening_bottom_of(o1), B-_-_).
test(openings_of_a_thing, Os == [o1, o2]) :-
    found(opening_through(t1, O), O, Os).
test(the_largest_first, Os == [[o1, o2]]) :-
    found(largest_openings(t1, O), O, Os).
test(in_a_face, [S, T, U] == [holds, fails, unknown]) :-
    state(opening_in(o1, f1), S),
    state(opening_in(o2, f1), T),
    state(opening_in(o1, unseen), U).
test(framed, [S, T] == [holds, fails]) :-
    state(frames(p1, o1), S),
    state(frames(p2, o1), T).
test(above_and_below, [S, T] == [holds, fails]) :-
    state(opening_above(o2, o1), S),
    state(opening_below(o2, o1), T).
test(nothing_is_higher_where_up_is_not_known, State == unknown) :-
    state(opening_above(o3, o1), State).
test(in_a_piece, [S, T] == [holds, fails]) :-
    state(opening_in(o1, p1), S),
    state(opening_in(o2, p1), T).
test(inside, [S, T, U] == [holds, fails, unknown]) :-
    state(piece_inside(p2, o1), S),
    state(piece_inside(o1, p2), T),
    state(piece_inside(p1, o1), U).
test(beside, [S, T, U] == [holds, fails, unknown]) :-
    state(piece_beside(p3, o2), S),
    state(piece_beside(p1, o1), T),
    state(piece_beside(p1, unseen), U).
test(more_may_be_there_until_all_are_known, [S, T] == [unknown, holds]) :-
    state(openings_known(t1), S),
    state(openings_known(t2), T).
test(too_few_fail_where_all_are_known, [S, T, U] == [unknown, fails, holds]) :-
    state(at_least_in(3, openings_known(t1), _, [[o1], [o2]], all([])), S),
    state(at_least_in(2, openings_known(t2), _, [[o3]], all([])), T),
    state(at_least_in(1, openings_known(t2), _, [[o3]], all([])), U).
test(hangs, [S, T, U] == [holds, fails, unknown]) :-
    state(hangs_from(p2, p1), S),
    state(hangs_from(p1, p2), T),
    state(hangs_from(p3, p1), U).

:- end_tests(openings).
