% Verdicts as relations, and what is remembered of a scene.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(named_models)).
:- use_module(facetlog_kb(recall)).
:- use_module(facetlog_kb(plan)).
:- use_module(facetlog_kb(ask)).

:- dynamic scene_now/1.

:- forall(member(Model, [box, table, chair]),
          ( absolute_file_name(facetlog(Model), Path, [extensions([pl]), access(read)]),
            load_builtin(Path, loaded(Module, Models, _, [])),
            name_models(test, Models, Module) )).

% Three faces of a block that meet at v1, and a thing of one face.
block_fact(scale(unknown)).
block_fact(thing(t1)).
block_fact(thing(t2)).
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

with_block :-
    gensym(test_scene, Scene),
    new_scene(Scene),
    forall(block_fact(Fact), assertz(Scene:Fact)),
    asserta(scene_now(Scene)).

without :-
    retract(scene_now(Scene)),
    destroy_scene(Scene).

ask(Goal) :-
    scene_now(Scene),
    b_setval(facetlog_base, test-all),
    in_scene(Scene, Goal).

remembered(Count) :-
    scene_now(Scene),
    aggregate_all(count, Scene:'facetlog recall'(_, _, _, _, _, _), Count).

:- begin_tests(ask, [ setup(with_block), cleanup(without) ]).

test(all_pairs_are_enumerated, all(T-M == [t1-box])) :-
    ask(is_a(T, M)).
test(bound_arguments_are_tested, [nondet]) :-
    ask(is_a(t1, box)).
test(what_does_not_hold_is_no_answer, fail) :-
    ask(is_a(t2, box)).
test(assignments_are_those_for_which_all_holds, all(M-T-P == [box-t1-[f1, f2, f3]])) :-
    ask(assignment(M, T, P)).
test(an_assignment_can_be_tested, fail) :-
    ask(assignment(box, t1, [f1, f3, f2])).
test(a_thing_that_is_not_there_is_nothing, fail) :-
    ask(is_a(t9, _)).
test(each_thing_and_model_has_one_verdict, Count == 6) :-
    ask(aggregate_all(count, verdict(_, _, _, _), Count)).
test(state_and_degree_are_told, [true(D > 0.99), nondet]) :-
    ask(verdict(t1, box, holds, D)).
test(too_little_seen_is_unknown, [true(S == unknown), nondet]) :-
    ask(verdict(t2, box, S, _)).
test(each_face_plays_one_role, set(F-R == [f1-a, f2-b, f3-c])) :-
    ask(plays(F, R, t1, box)).
test(no_face_plays_in_what_does_not_hold, fail) :-
    ask(plays(_, _, t2, box)).
test(asking_again_costs_little, [true(Again*20 < First)]) :-
    without,
    with_block,
    cost(First),
    cost(Again).
test(new_rules_make_a_scene_forget) :-
    ask(forall(verdict(_, _, _, _), true)),
    remembered(Before),
    forget_all,
    ask(forall(verdict(t1, box, _, _), true)),
    remembered(After),
    assertion(Before >= 6),
    assertion(After == 1).
test(a_dropped_scene_leaves_nothing) :-
    without,
    with_block,
    ask(forall(is_a(_, _), true)),
    scene_now(Scene),
    without,
    with_block,
    assertion(\+ current_module(Scene)),
    assertion(\+ current_predicate(Scene:'facetlog recall'/6)).

cost(Inferences) :-
    statistics(inferences, Before),
    ask(forall(is_a(t1, box), true)),
    statistics(inferences, After),
    Inferences is After - Before.

:- end_tests(ask).

:- begin_tests(plan).

test(costly_conditions_come_last, Last == sides) :-
    plan(box, box, Plan),
    last(Plan, group(label(Last), 1)).
test(all_conditions_are_in_the_plan, N == 7) :-
    plan(box, box, [group(_, N)|_]).
test(a_body_that_may_give_several_has_no_bound) :-
    \+ facetlog_plan:at_most_one(member(_, [a, b]), user, 0).
test(definitions_are_looked_through) :-
    context_module(Here),
    facetlog_plan:at_most_one(two_steps(_), Here, 0).
test(a_definition_of_two_clauses_has_no_bound) :-
    context_module(Here),
    \+ facetlog_plan:at_most_one(either(_), Here, 0).

two_steps(Sorted) :-
    one_step(List),
    sort(List, Sorted).

one_step([b, a]).

either(a).
either(b).

:- end_tests(plan).
