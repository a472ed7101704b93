% The built-in models on facts written by hand.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog(box), []).

% Three faces of a block, 10 by 8 by 6, that meet at v1.
block(Facts) :-
    findall(Fact, block_fact(Fact), Facts).

block_fact(scale(unknown)).
block_fact(thing(t1)).
block_fact(thing_size(t1, 10.0, 8.0, 6.0)).
block_fact(solidity(t1, 1.0, 0.01)).
block_fact(hollow_side(t1, 0.0, 0.01)).
block_fact(curved(t1, 0.0)).
block_fact(Fact) :-
    member(F, [f1, f2, f3]),
    member(Fact, [face(F), part_of(F, t1), evidence(F, measured), corner(F, 1, v1),
                  area(F, 60.0, 0.5), share(F, 1.0, 0.01), fill(F, 1.0, 0.01), width(F, 6.0, 0.05),
                  protrusion(F, 0.0, 0.02)]).
block_fact(Fact) :-
    member(A-B-E, [f1-f2-e1, f2-f1-e1, f1-f3-e2, f3-f1-e2, f2-f3-e3, f3-f2-e3]),
    member(Fact, [angle(A, B, 91.0, 0.5), adjoins(A, B, E), dihedral(A, B, 89.0, 0.5),
                  convex(A, B)]).
block_fact(edge_length(E, L, 0.05)) :-
    member(E-L, [e1-8.0, e2-10.0, e3-6.0]).
block_fact(reach_behind(F, R, 0.05)) :-
    member(F-R, [f1-6.0, f2-10.0, f3-8.0]).

state(Facts, State) :-
    verdict(Facts, verdict(_, _, State, _, _, _, _, _, _, _)).

verdict(Facts, Verdict) :-
    setup_call_cleanup(
        ( gensym(test_scene, Scene), new_scene(Scene) ),
        ( forall(member(Fact, Facts), assertz(Scene:Fact)),
          in_scene(Scene, judge(box, box, t1, Verdict)) ),
        destroy_scene(Scene)).

% The block with each of the old facts taken out and the new ones put in.
changed(Old, New, Facts) :-
    block(Facts0),
    exclude([Fact]>>( member(Out, Old), \+ Fact \= Out ), Facts0, Kept),
    append(New, Kept, Facts).

:- begin_tests(box).

test(three_faces_are_a_box, State == holds) :-
    block(Facts),
    state(Facts, State).
test(sizes_are_between_sides_longest_first, Sizes == [length-10.0, width-8.0, height-6.0]) :-
    block(Facts),
    verdict(Facts, verdict(_, _, _, _, _, _, Named, _, _, _)),
    findall(N-V, member(size(N, V, _, _), Named), Sizes).
test(each_choice_of_faces_is_proposed_once, Also == 0) :-
    block(Facts),
    verdict(Facts, verdict(_, _, _, _, _, _, _, _, Also, _)).
test(what_sticks_out_is_no_box, State == fails) :-
    changed([protrusion(_, _, _)],
            [protrusion(f1, 2.0, 0.02), protrusion(f2, 2.0, 0.02), protrusion(f3, 2.0, 0.02)], Facts),
    state(Facts, State).
test(faces_that_do_not_fill_their_sides_leave_a_box_open, State == unknown) :-
    changed([share(_, _, _)],
            [share(f1, 0.1, 0.02), share(f2, 0.1, 0.02), share(f3, 0.1, 0.02)], Facts),
    state(Facts, State).
test(what_has_room_within_is_no_box, State == fails) :-
    changed([solidity(t1, _, _)], [solidity(t1, 0.5, 0.01)], Facts),
    state(Facts, State).
test(a_hollow_side_makes_it_no_box, State == fails) :-
    changed([hollow_side(t1, _, _)], [hollow_side(t1, 0.9, 0.01)], Facts),
    state(Facts, State).
test(what_unseen_space_may_empty_is_left_open, State == unknown) :-
    changed([], [unseen_bounds(solidity, t1, 0.5, 1.0)], Facts),
    state(Facts, State).
test(unseen_space_that_changes_nothing_leaves_a_box, State == holds) :-
    changed([], [unseen_bounds(solidity, t1, 0.9, 1.0)], Facts),
    state(Facts, State).
test(skew_face_is_no_box, State == fails) :-
    changed([angle(f1, f2, _, _), angle(f2, f1, _, _)],
            [angle(f1, f2, 120.0, 0.5), angle(f2, f1, 120.0, 0.5)], Facts),
    state(Facts, State).
test(face_in_a_fourth_direction_is_no_box, State \== holds) :-
    changed([], [ face(f4), part_of(f4, t1), evidence(f4, measured), area(f4, 30.0, 0.5),
                  angle(f4, f1, 45.0, 1.0), angle(f4, f2, 55.0, 1.0), angle(f4, f3, 60.0, 1.0) ],
            Facts),
    state(Facts, State).
test(speck_in_a_fourth_direction_contradicts_nothing, State == holds) :-
    changed([], [ face(f4), part_of(f4, t1), evidence(f4, measured), area(f4, 0.3, 0.01),
                  angle(f4, f1, 45.0, 1.0), angle(f4, f2, 55.0, 1.0), angle(f4, f3, 60.0, 1.0) ],
            Facts),
    state(Facts, State).
test(one_measured_face_leaves_a_box_open, State == unknown) :-
    changed([evidence(f2, _), evidence(f3, _)], [evidence(f2, implied), evidence(f3, implied)], Facts),
    state(Facts, State).

:- end_tests(box).
