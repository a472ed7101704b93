% What a test may ask of other models, and of all assignments of a model at once.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(named_models)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(in_progress)).
:- use_module(facetlog_kb(left_open)).
:- use_module(facetlog_kb(model_test)).

% Goal of a module with these clauses, in a scene with two faces of which one is tilted.
among_rules(Clauses, Module, Goal) :-
    facetlog_bridge:ask_base(other_models, all),
    gensym(other_models, Module),
    gensym(other_models, Scene),
    setup_call_cleanup(
        ( new_rule_module(Module), new_scene(Scene) ),
        ( forall(member(Clause, Clauses), assertz(Module:Clause)),
          findall(Model, member(model(Model, _, _), Clauses), Models),
          name_models(other_models, Models, Module),
          forall(member(Fact, [ thing(t1), face(f1), face(f2), part_of(f1, t1), part_of(f2, t1),
                                evidence(f1, measured), evidence(f2, measured), upward(f2), tilt(f1, 20.0, 0.0) ]),
                 assertz(Scene:Fact)),
          in_scene(Scene, once(Goal)) ),
        ( destroy_scene(Scene), unname_models(other_models, Module), '$destroy_module'(Module) )).

:- begin_tests(left_open).

% So many assignments to t1, and the lengths of their blocks.
lengths(Clauses, Count, Lengths) :-
    findall(t1-[f, Face],
            ( between(1, Count, Number), format(atom(Face), "g~|~`0t~d~3+", [Number]) ), Candidates),
    among_rules(Clauses, Module, blocks(Module, m, Candidates, Blocks)),
    append(Blocks, All),
    assertion(All == Candidates),
    maplist(length, Blocks, Lengths).

% Which way a face that was not measured is turned nobody knows.
open([ condition(m, a, "", _, [A, _], upward(A)) ]).
open([ condition(m, a, "", _, [_, B], upward(B)) ]).
open([ condition(m, a, "", _, [_, _], upward(f)) ]).
open([ condition(m, a, "", _, [_, _], upward(f2)), condition(m, b, "", _, [A, _], upward(A)) ]).
open([ condition(m, a, "", T, [A, _], all([upward(A), is_a(T, m)])), model(m, "", [a, b]) ]).

closed([]).
closed([ condition(m, a, "", _, [_, _], upward(f2)) ]).
closed([ condition(m, a, "", _, [A, B], any([upward(A), upward(B)])) ]).
closed([ condition(other, a, "", _, [A, _], upward(A)) ]).
closed([ condition(m, a, "", t2, [A, _], upward(A)) ]).
closed([ condition(m, a, "", _, [_, _], _) ]).
closed([ ( condition(m, a, "", _, [A, _], upward(A)) :- fail ) ]).

test(blocks_where_nothing_holds, forall(open(Clauses))) :-
    lengths(Clauses, 8, Lengths),
    assertion(Lengths == [6, 2]).
test(one_block_where_something_may, forall(closed(Clauses))) :-
    lengths(Clauses, 8, Lengths),
    assertion(Lengths == [8]).
test(one_that_holds_is_enough, Lengths == [8]) :-
    lengths([condition(m, a, "", _, [_, B], any([upward(B), near(count([B]), 1, 0)]))], 8, Lengths).
test(as_many_as_fit, All == [[], [6], [6, 1], [6, 6], [6, 6, 1]]) :-
    open(Clauses),
    !,
    maplist(lengths(Clauses), [0, 6, 7, 12, 13], [None|Some]),
    ( None == [0] -> All = [[]|Some] ; All = [None|Some] ).
test(the_condition_of_fewest_parts_is_asked_first_and_once_for_the_same, Count == 1) :-
    flag(other_models, _, 0),
    lengths([ condition(m, a, "", _, [_, B], counted(B)),
              condition(m, b, "", _, [_, _], counted(f)),
              condition(m, c, "", _, [_, B1], counted(B1)),
              ( means(counted(A), upward(A)) :- flag(other_models, N, N + 1) ) ], 8, [6, 2]),
    flag(other_models, Count, Count).

:- end_tests(left_open).

:- begin_tests(model_tests).

rules([ model(m, "", [low, high]),
        ( candidate(m, T, [A, B]) :- face_of(T, A), face_of(T, B), A @< B ),
        condition(m, a, "", _, [_, B], upward(B)),
        model(never, "", [one]),
        ( candidate(never, T, [A]) :- face_of(T, A) ),
        condition(never, a, "", _, [_], any([])),
        model(nothing, "", [one]),
        ( candidate(nothing, _, [_]) :- fail ) ]).

of_models(Goal) :-
    rules(Clauses),
    among_rules(Clauses, _, Goal).

test(parts, Parts == [f1, f2, unseen, unseen, unseen, unseen, unseen]) :-
    findall(Part,
            ( member(Thing-Model-Role, [ t1-m-low, t1-m-high, t1-m-middle, unseen-m-low, t9-m-low, t1-never-one,
                                         t1-nothing-one ]),
              of_models(part_in(Thing, Model, Role, Part)) ),
            Parts).
test(outcomes, Outcomes == [ outcome(holds, 1, 1, none), outcome(unknown, 0, 1, unseen),
                             outcome(unknown, 0, 1, unstated), outcome(unknown, 0, 1, unstated),
                             outcome(unknown, 0, 1, unstated),
                             outcome(fails, 0, 0, none), outcome(unknown, 0, 1, none) ]) :-
    findall(Outcome,
            ( member(Thing-Model, [t1-m, unseen-m, t9-m, f(t1)-m, _-m, t1-never, t1-nothing]),
              of_models(( model_outcome(Thing, Model, Outcome), model_state(Thing, Model, State),
                          arg(1, Outcome, State) )) ),
            Outcomes).
test(what_is_being_judged, Found == outcome(unknown, 0, 1, cycle)-unknown-unseen) :-
    rules(Clauses),
    among_rules(Clauses, Module,
                while_judging(Module, m, t1, ( model_outcome(t1, m, Outcome), model_state(t1, m, State),
                                               part_in(t1, m, low, Part) ))),
    Found = Outcome-State-Part.
test(no_such_model, throws(error(existence_error(model, nosuch), _))) :-
    of_models(part_in(t1, nosuch, low, _)).

:- end_tests(model_tests).
