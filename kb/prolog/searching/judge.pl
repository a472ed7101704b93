:- module(facetlog_judge, [ judge/4,          % +Module, +Model, +Thing, -Verdict
                            best/4,           % +Module, +Model, +Thing, -Best
                            best_of/4,        % +Module, +Model, +Candidates, -Best
                            best_by/6,        % +Plan, +Module, +Model, +Candidates, -Found, -Queue
                            open_candidates/4, % +Module, +Model, +Candidates, -Open
                            outcome/4,        % +Module, +Model, +Thing, -Outcome
                            verdict_of/5,     % +Best, +Module, +Model, +Thing, -Verdict
                            prove/6           % +Module, +Model, +Thing, +Parts, +Also, -Verdict
                          ]).

/** <module> Models into verdicts

A model's candidate/3 proposes faces for its parts. The best assignment is found without proofs
(search.pl); only that one is proved. A verdict is

    verdict(Model, Thing, State, Low, High, Parts, Sizes, Conditions, Also, General)

Parts is a list of Role-Face and, for sets beside the parts, group(Role, Faces); Sizes of
size(Name, Value, Sd, Measure), Conditions of condition(Label, Reason, Proof, Place, Text), where
Place and Text are what the author wrote where, or ''; Also counts the other assignments that hold;
General lists the models of which this one is a special case.
*/

:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(prove)).
:- use_module(facetlog_kb(in_progress)).
:- use_module(facetlog_kb(plan)).
:- use_module(facetlog_kb(search)).
:- use_module(facetlog_kb(left_open)).
:- use_module(facetlog_kb(model_descriptions)).
:- use_module(facetlog_kb(recall)).

%!  judge(+Module, +Model, +Thing, -Verdict) is det.
%
%   Verdict is on the best assignment of faces to the parts of Model.

judge(Module, Model, Thing, Verdict) :-
    best(Module, Model, Thing, Best),
    verdict_of(Best, Module, Model, Thing, Verdict).

%!  outcome(+Module, +Model, +Thing, -Outcome) is det.
%
%   Outcome is outcome(State, Low, High) of the verdict. It is remembered with the scene.

outcome(Module, Model, Thing, Outcome) :-
    recall(Module, Model, Thing, outcome, Outcome,
           ( judge(Module, Model, Thing, Verdict),
             Verdict = verdict(_, _, State, Low, High, _, _, _, _, _),
             Outcome = outcome(State, Low, High) )).

%!  verdict_of(+Best, +Module, +Model, +Thing, -Verdict) is det.
%
%   Verdict is on Best, as best/4 gives it; on Thing if nothing was proposed.

verdict_of(none, Module, Model, Thing,
           verdict(Model, Thing, unknown, 0, 1, [], [], [], 0, General)) :-
    general_models(Module, Model, General).
verdict_of(best(_, Thing, Parts, Also), Module, Model, _, Verdict) :-
    prove(Module, Model, Thing, Parts, Also, Verdict).

%!  best(+Module, +Model, +Thing, -Best) is det.
%
%   Best is best(State, Thing, Parts, Also), or none if nothing is proposed. It is remembered with
%   the scene.

best(Module, Model, Thing, Best) :-
    recall(Module, Model, Thing, best, Best,
           while_judging(Module, Model, Thing, find_best(Module, Model, Thing, Best))).

find_best(Module, Model, Thing, Best) :-
    candidates(Module, Model, Thing, Candidates),
    best_of(Module, Model, Candidates, Best).

%!  best_of(+Module, +Model, +Candidates, -Best) is det.
%
%   The best of Candidates, a list of Thing-Parts: one of which all conditions hold; else the first of
%   those that do not fail; else the nearest miss. Where none can hold (left_open.pl), the first of
%   those that do not fail in the first block that has one.

best_of(Module, Model, Candidates, Best) :-
    plan(Module, Model, Plan),
    best_by(Plan, Module, Model, Candidates, Found, Queue),
    (   Found = found(Thing, Parts, _)
    ->  in_all(Found, State),
        ( State == holds -> others_that_hold(Module, Model, Queue, Also) ; Also = 0 ),
        Best = best(State, Thing, Parts, Also)
    ;   Best = none
    ).

%!  best_by(+Plan, +Module, +Model, +Candidates, -Found, -Queue) is det.
%
%   Found is found(Thing, Parts, Tally) of the best, or `none`; Queue is what search.pl leaves of its
%   block.

best_by(Plan, Module, Model, Candidates, Found, Queue) :-
    blocks(Module, Model, Candidates, Blocks),
    best_in_blocks(Blocks, aim(verdict, Module, Model), Plan, none, Found, Queue).

%!  open_candidates(+Module, +Model, +Candidates, -Open) is det.
%
%   Open is the block that best_by/6 stops at, if there is one in which an assignment does not fail;
%   else all of Candidates.

open_candidates(Module, Model, Candidates, Open) :-
    blocks(Module, Model, Candidates, Blocks),
    (   Blocks = [_]
    ->  Open = Candidates
    ;   plan(Module, Model, Plan),
        member(Open, Blocks),
        best_in_blocks([Open], aim(verdict, Module, Model), Plan, none, Found, _),
        Found \== none,
        \+ in_all(Found, fails)
    ->  true
    ;   Open = Candidates
    ).

%   Best0 is Key-Found of the blocks before, all of which fail, or none.
best_in_blocks([], _, _, Best0, Found, Queue) :-
    ( Best0 = _-Found -> true ; Found = none ),
    Queue = none.
best_in_blocks([Block|Blocks], Aim, Plan, Best0, Found, Queue) :-
    start(Aim, Block, Plan, Queue0),
    (   next_best(Aim, Queue0, Queue1, Found1)
    ->  (   in_all(Found1, fails)
        ->  Aim = aim(Sought, _, _),
            Found1 = found(Thing, Parts, Tally),
            key(Sought, open(Thing, Parts, Tally, []), Key),
            ( Best0 = Key0-_, Key0 @< Key -> Nearest = Best0 ; Nearest = Key-Found1 ),
            best_in_blocks(Blocks, Aim, Plan, Nearest, Found, Queue)
        ;   Found = Found1,
            Queue = Queue1
        )
    ;   best_in_blocks(Blocks, Aim, Plan, Best0, Found, Queue)
    ).

%   Those that hold come before all that do not.
others_that_hold(Module, Model, Queue0, Count) :-
    (   next_best(aim(verdict, Module, Model), Queue0, Queue, Found),
        in_all(Found, holds)
    ->  others_that_hold(Module, Model, Queue, Count0),
        Count is Count0 + 1
    ;   Count = 0
    ).

%!  prove(+Module, +Model, +Thing, +Parts, +Also, -Verdict) is det.
%
%   The verdict on one assignment, with the proofs of its conditions in the order of the file.

prove(Module, Model, Thing, Parts, Also, Verdict) :-
    while_judging(Module, Model, Thing, proved(Module, Model, Thing, Parts, Also, Verdict)).

proved(Module, Model, Thing, Parts, Also,
       verdict(Model, Thing, State, Low, High, Roled, Sizes, Conditions, Also, General)) :-
    roled(Module, Model, Thing, Parts, Roled),
    findall((Label-Reason)-Test,
            Module:condition(Model, Label, Reason, Thing, Parts, Test),
            Tests),
    maplist(prove_condition(Module, Model), Tests, Conditions, Proofs),
    all_proved(Proofs, State, Low, High),
    sizes(Module, Model, Thing, Parts, Sizes),
    general_models(Module, Model, General).

prove_condition(Module, Model, (Label-Reason)-Test,
                condition(Label, Reason, Proof, Place, Text), Proof) :-
    written(Module, Model, Label, Place, Text),
    evaluate(Test, Module, Proof).

sizes(Module, Model, Thing, Parts, Sizes) :-
    (   current_predicate(Module:size/5)
    ->  findall(size(Name, V, Sd, Measure),
                ( Module:size(Model, Thing, Parts, Name, Measure),
                  value(Measure, Module, quantity(V, Var, length)),
                  Sd is sqrt(Var) ),
                Sizes)
    ;   Sizes = []
    ).
