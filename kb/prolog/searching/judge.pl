:- module(facetlog_judge, [ judge/4,          % +Module, +Model, +Thing, -Verdict
                            standing/4,       % +Module, +Model, +Thing, -Standing
                            best_of/4,        % +Target, +Model, +Candidates, -Best
                            found_in/6,       % +Target, +Module, +Model, +Thing, -Count, -Found
                            considered/5,     % +Target, +Module, +Model, +Thing, -Candidates
                            outcome/4,        % +Module, +Model, +Thing, -Outcome
                            verdict_of/5,     % +Best, +Module, +Model, +Thing, -Verdict
                            prove/6           % +Module, +Model, +Thing, +Parts, +Also, -Verdict
                          ]).

/** <module> Models into verdicts

A model's candidate/3 proposes faces for its parts. The best assignment is found without proofs
(search.pl), by the specialised rules Target of the model (code.pl); only that one is proved. A verdict is

    verdict(Model, Thing, State, Low, High, Parts, Sizes, Conditions, Also, General)

Parts is a list of Role-Face and, for sets beside the parts, group(Role, Faces); Sizes of
size(Name, Value, Sd, Measure), Conditions of condition(Label, Reason, Proof, Place, Text), where
Place and Text are what the author wrote where, or ''; Also counts the other assignments that hold;
General lists the models of which this one is a special case.
*/

:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(solution_sequences)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(prove)).
:- use_module(facetlog_kb(in_progress)).
:- use_module(facetlog_kb(code)).
:- use_module(facetlog_kb(specialise)).
:- use_module(facetlog_kb(search)).
:- use_module(facetlog_kb(left_open)).
:- use_module(facetlog_kb(model_descriptions)).
:- use_module(facetlog_kb(recall)).

%!  judge(+Module, +Model, +Thing, -Verdict) is det.
%
%   Verdict is on the best assignment of faces to the parts of Model. What is found is remembered with the
%   scene.

judge(Module, Model, Thing, Verdict) :-
    recall(Module, Model, Thing, best, Best,
           searching(Module, Model, Thing, Target, find_best(Target, Module, Model, Thing, Best))),
    verdict_of(Best, Module, Model, Thing, Verdict).

:- meta_predicate searching(+, +, +, -, 0).

searching(Module, Model, Thing, Target, Goal) :-
    with_code(Module, Model, Target, while_judging(Module, Model, Thing, Goal)).

find_best(Target, Module, Model, Thing, Best) :-
    considered(Target, Module, Model, Thing, Candidates),
    best_of(Target, Model, Candidates, Best).

%!  standing(+Module, +Model, +Thing, -Standing) is det.
%
%   Standing is standing(State, Parts) of the verdict, without its proof, or none if nothing is proposed;
%   Parts are those of the best assignment where State is not `fails`. It is remembered with the scene.

standing(Module, Model, Thing, Standing) :-
    recall(Module, Model, Thing, standing, Standing,
           ( searching(Module, Model, Thing, Target, found_in(Target, Module, Model, Thing, _, Found)),
             standing_of(Found, Standing) )).

standing_of(none, none).
standing_of(refused, standing(fails, [])).
standing_of(found(Thing, Parts, Tally), standing(State, Parts)) :-
    in_all(found(Thing, Parts, Tally), State).

%!  outcome(+Module, +Model, +Thing, -Outcome) is det.
%
%   Outcome is outcome(State, Low, High) of the verdict. It is remembered with the scene.

outcome(Module, Model, Thing, Outcome) :-
    recall(Module, Model, Thing, outcome, Outcome,
           searching(Module, Model, Thing, Target, find_outcome(Target, Module, Model, Thing, Outcome))).

find_outcome(Target, Module, Model, Thing, Outcome) :-
    considered(Target, Module, Model, Thing, Candidates),
    (   best_by(Target, Model, Candidates, found(_, Parts, _), _)
    ->  all_outlined(Target, Model, Thing, Parts, outline(State, Low, High)),
        Outcome = outcome(State, Low, High)
    ;   Outcome = outcome(unknown, 0, 1)
    ).

%!  found_in(+Target, +Module, +Model, +Thing, -Count, -Found) is det.
%
%   Found is found(Thing, Parts, Tally) of the best of the Count assignments that are considered; `none` if
%   there are none; `refused` if each has a degree of next to nothing: which of them is the nearest miss is
%   for those to find who ask.

found_in(Target, Module, Model, Thing, Count, Found) :-
    considered(Target, Module, Model, Thing, Candidates),
    length(Candidates, Count),
    (   Count =:= 0
    ->  Found = none
    ;   all_hopeless(Target, Model, Candidates)
    ->  Found = refused
    ;   best_by(Target, Model, Candidates, Found, _)
    ).

%!  verdict_of(+Best, +Module, +Model, +Thing, -Verdict) is det.
%
%   Verdict is on Best, as best/4 gives it; on Thing if nothing was proposed.

verdict_of(none, Module, Model, Thing,
           verdict(Model, Thing, unknown, 0, 1, [], [], [], 0, General)) :-
    general_models(Module, Model, General).
verdict_of(best(_, Thing, Parts, Also), Module, Model, _, Verdict) :-
    prove(Module, Model, Thing, Parts, Also, Verdict).

%!  best_of(+Target, +Model, +Candidates, -Best) is det.
%
%   Best is best(State, Thing, Parts, Also) on the best of Candidates, a list of Thing-Parts: one of which all
%   conditions hold, with how many others hold as well; else the first of those that do not fail; else the
%   nearest miss. It is `none` if there are no Candidates.

best_of(Target, Model, Candidates, Best) :-
    (   best_by(Target, Model, Candidates, found(Thing, Parts, Tally), Queue)
    ->  in_all(found(Thing, Parts, Tally), State),
        ( State == holds -> others_that_hold(Queue, Also) ; Also = 0 ),
        Best = best(State, Thing, Parts, Also)
    ;   Best = none
    ).

%   Found is found(Thing, Parts, Tally) of the best; Queue is what search.pl leaves. Fails if there is none.
best_by(Target, Model, Candidates, Found, Queue) :-
    Target:plan(Model, Plan),
    start(verdict, Candidates, Plan, Queue0),
    next_best(verdict, Queue0, Queue, Found).

%!  considered(+Target, +Module, +Model, +Thing, -Candidates) is det.
%
%   Candidates are what the model proposes, a sorted list of Thing-Parts; where none of them can hold
%   (left_open.pl) only the first few in turn of which one does not fail, for that is as good as any.

considered(Target, Module, Model, Thing, Candidates) :-
    (   first_open(Target, Module, Model, Thing, Candidates0)
    ->  Candidates = Candidates0
    ;   candidates(Target, Model, Thing, Candidates)
    ).

%   As many as are tried for the first of several parts that may be unseen (joins.py).
few(6).

first_open(Target, Module, Model, Thing, Open) :-
    Target:in_turn(Model),
    few(Few),
    More is Few + 1,
    findall(Thing-Parts, limit(More, Target:candidate(Model, Thing, Parts)), First),
    length(First, More),
    \+ all_hopeless(Target, Model, First),
    none_can_hold(Target, Module, Model, Thing),
    findnsols(Few, Thing-Parts, Target:candidate(Model, Thing, Parts), Next),
    sort(Next, Open),
    best_by(Target, Model, Open, Found, _),
    \+ in_all(Found, fails),
    !.

%   Those that hold come before all that do not.
others_that_hold(Queue0, Count) :-
    (   next_best(verdict, Queue0, Queue, Found),
        in_all(Found, holds)
    ->  others_that_hold(Queue, Count0),
        Count is Count0 + 1
    ;   Count = 0
    ).

%!  prove(+Module, +Model, +Thing, +Parts, +Also, -Verdict) is det.
%
%   The verdict on one assignment, with the proofs of its conditions in the order of the file.

prove(Module, Model, Thing, Parts, Also, Verdict) :-
    searching(Module, Model, Thing, Target, proved(Target, Module, Model, Thing, Parts, Also, Verdict)).

proved(Target, Module, Model, Thing, Parts, Also,
       verdict(Model, Thing, State, Low, High, Roled, Sizes, Conditions, Also, General)) :-
    roled(Module, Model, Target, Thing, Parts, Roled),
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
