% What a test may ask of other models, and of all assignments of a model at once.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(named_models)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(in_progress)).
:- use_module(facetlog_kb(left_open)).
:- use_module(facetlog_kb(code)).
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

% Whether nothing that the scene has can be what the rules with these clauses ask for.
none(Clauses) :-
    among_rules([model(m, "", [a, b]), ( candidate(m, T, [A, B]) :- face_of(T, A), face_of(T, B) )|Clauses], Module,
                ( with_code(Module, m, Target, none_can_hold(Target, Module, m, t1)) )).

% Face f1 is tilted by 20 degrees, f2 is level and faces up; nobody has measured an angle.
nothing_holds([ condition(m, a, "", _, [A, _], at_least(fill(A), 0.5)) ]).
nothing_holds([ condition(m, a, "", _, [_, B], all([upward(B), at_least(fill(B), 0.5)])) ]).
nothing_holds([ condition(m, a, "", _, [A, _], upward(A)), condition(m, b, "", _, [_, B], at_least(fill(B), 0.5)) ]).

something_may([]).
something_may([ condition(m, a, "", _, [A, _], upward(A)) ]).
something_may([ condition(m, a, "", _, [A, B], all([at_least(fill(A), 0.5), upward(B)])) ]).
something_may([ condition(other, a, "", _, [A, _], at_least(fill(A), 0.5)) ]).
something_may([ condition(m, a, "", t2, [A, _], at_least(fill(A), 0.5)) ]).
something_may([ ( condition(m, a, "", _, [A, _], at_least(fill(A), 0.5)) :- fail ) ]).

test(what_nothing_can_be, forall(nothing_holds(Clauses))) :-
    assertion(none(Clauses)).
test(what_something_may_be, forall(something_may(Clauses))) :-
    assertion(\+ none(Clauses)).

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
