:- module(facetlog_recall, [ recall/6,        % +Module, +Model, +Thing, +What, -Answer, :Goal
                             forget_all/0
                           ]).

/** <module> What was found out about a scene

Answers are kept in the scene's own module, so that they go when the scene goes. They follow from
the rules of their day: when rules come or go a new day begins, and a scene that is asked again
forgets what it knew.
*/

:- use_module(library(aggregate)).
:- use_module(facetlog_kb(small_terms)).
:- use_module(facetlog_kb(in_progress)).

:- meta_predicate recall(+, +, +, +, -, 0).

%!  recall(+Module, +Model, +Thing, +What, -Answer, :Goal) is det.
%
%   Answer is what Goal binds it to, found once for the current scene and remembered, if what was
%   asked is known and small and does not depend on what is being judged at the moment. But for the time
%   that takes it is
%
%     ==
%     recall(_, _, _, _, _, Goal) :- once(Goal).
%     ==
%
%   @error resource_error(term_size) if the question or the answer is too deep or too large.

recall(Module, Model, Thing, What, Answer, Goal) :-
    must_be_small(Thing-What),
    (   ground(Thing-What),
        small_key(Thing-What)
    ->  recall_known(Module, Model, Thing, What, Answer, Goal)
    ;   once(Goal)
    ).

recall_known(Module, Model, Thing, What, Answer, Goal) :-
    b_getval(facetlog_scene, Scene),
    flag(facetlog_day, Day, Day),
    (   current_predicate(Scene:'facetlog recall'/6),
        Scene:'facetlog recall'(Thing, What, Model, Module, Day, Answer0)
    ->  Answer = Answer0
    ;   unless_cyclic(Goal, Cyclic),
        must_be_small(Answer),          % parts are what a candidate/3 says
        (   Cyclic == true
        ->  true
        ;   remember(Scene, Module, Model, Thing, What, Day, Answer)
        )
    ).

%   Two threads may have found it out at once: one answer is enough.
remember(Scene, Module, Model, Thing, What, Day, Answer) :-
    with_mutex(facetlog_recall,
               (   dynamic(Scene:'facetlog recall'/6),
                   forget_other_days(Scene, Day),
                   (   Scene:'facetlog recall'(Thing, What, Model, Module, Day, _)
                   ->  true
                   ;   make_room(Scene, Thing, Model),
                       assertz(Scene:'facetlog recall'(Thing, What, Model, Module, Day, Answer))
                   ) )).

%   Answers about one thing of one model that a scene remembers. A scene has few of each, but may be
%   asked for pairs by any number of tests: then the oldest goes.
most_answers(64).

make_room(Scene, Thing, Model) :-
    most_answers(Most),
    Old = Scene:'facetlog recall'(Thing, _, Model, _, _, _),
    aggregate_all(count, clause(Old, true), Count),
    (   Count < Most
    ->  true
    ;   clause(Old, true, Oldest),
        erase(Oldest)
    ),
    !.

%   All answers of a scene are of one day.
forget_other_days(Scene, Day) :-
    (   once(Scene:'facetlog recall'(_, _, _, _, Day0, _)),
        Day0 =\= Day
    ->  retractall(Scene:'facetlog recall'(_, _, _, _, _, _))
    ;   true
    ).

%!  forget_all is det.
%
%   Begins a new day: for when rules were loaded or dropped.

forget_all :-
    flag(facetlog_day, Day, Day + 1).
