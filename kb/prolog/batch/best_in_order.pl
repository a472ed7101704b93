:- module(facetlog_best_in_order, [ best_in_order/5    % +Candidates, +Target, +Plan, -Thing, -Parts
                                  ]).

/** <module> The best assignment, in two rounds

The same order as search.pl has, and so the same best. There the most promising one is asked next, one
condition at a time, as a test is dear; here a test costs less than to keep such a queue. So all are
asked what costs little first, and then, the most promising first, the rest: each until it is seen to
be behind the best so far, and none after the first that is behind it at once.
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(search)).

:- set_prolog_flag(optimise, true).

%!  best_in_order(+Candidates, +Target, +Plan, -Thing, -Parts) is semidet.
%
%   The best of Candidates, a list of Thing-Parts, by the conditions of Plan (specialise.pl). Fails if
%   there are none.

best_in_order([First|Candidates], Target, Plan, Thing, Parts) :-
    cheap_first(Plan, Cheap, Dear),
    first_round([First|Candidates], Target, Cheap, Dear, Round),
    sort(1, @=<, Round, Promising),
    second_round(Promising, Target, Dear, none, best(_, Thing, Parts)).

cheap_first([], [], []).
cheap_first([Ask|Plan], Cheap, Dear) :-
    (   Ask = ask(_, _, none)
    ->  Cheap = [Ask|Cheap1],
        cheap_first(Plan, Cheap1, Dear)
    ;   Cheap = [],
        Dear = [Ask|Plan]
    ).

%   open(Key, Thing, Parts, Tally) for each candidate; the key is a bound that further conditions can only worsen.
first_round([], _, _, _, []).
first_round([Thing-Parts|Candidates], Target, Cheap, Dear,
            [open(Key, Thing, Parts, Tally)|Round]) :-
    asked_all(Cheap, Target, Thing, Parts, tally(0, 0, 0, 1, 1, []), Tally),
    bound_key(Tally, Dear, Key),
    first_round(Candidates, Target, Cheap, Dear, Round).

asked_all([], _, _, _, Tally, Tally).
asked_all([ask(Name, _, _)|Asks], Target, Thing, Parts, Tally0, Tally) :-
    call(Target:Name, Thing, Parts, Outlines),
    count_all(Outlines, Tally0, Tally1),
    asked_all(Asks, Target, Thing, Parts, Tally1, Tally).

%   The first parts of a key of search.pl.
bound_key(tally(H, F, U, _, _, Misses), Dear, key(Order, Lacking, F, Total)) :-
    ( F > 0 -> Order = 2 ; U > 0 -> Order = 1 ; Order = 0 ),
    left(Dear, Left),
    Lacking is -(H + Left),
    total(Misses, Total).

second_round([], _, _, Best, Best).
second_round([open(_, Thing, Parts, Tally0)|Round], Target, Dear, Best0, Best) :-
    left(Dear, Left),
    (   not_behind(Best0, Tally0, Left)
    ->  (   asked(Dear, Target, Thing, Parts, Tally0, Best0, Tally),
            key(verdict, open(Thing, Parts, Tally, []), Key),
            before(Best0, Key)
        ->  Best1 = best(Key, Thing, Parts)
        ;   Best1 = Best0
        ),
        second_round(Round, Target, Dear, Best1, Best)
    ;   Best = Best0                    % and so are all that follow
    ).

before(none, _).
before(best(Best, _, _), Key) :- Key @< Best.

%   Fails as soon as the candidate is seen to be behind the best.
asked([], _, _, _, Tally, _, Tally).
asked([ask(Name, _, First)|Asks], Target, Thing, Parts, Tally0, Best, Tally) :-
    left(Asks, Left),
    in_reach(Best, First, Target, Thing, Parts, Tally0, Left),
    call(Target:Name, Thing, Parts, Outlines),
    count_all(Outlines, Tally0, Tally1),
    not_behind(Best, Tally1, Left),
    asked(Asks, Target, Thing, Parts, Tally1, Best, Tally).

left([], 0).
left([ask(_, Most, _)|_], Most).

%   Whether it would be behind if the condition fails is known before by how much it fails.
in_reach(none, _, _, _, _, _, _) :- !.
in_reach(_, none, _, _, _, _, _) :- !.
in_reach(Best, First, Target, Thing, Parts, tally(H, F0, U, L, P, Misses), Left) :-
    F is F0 + 1,
    (   not_behind(Best, tally(H, F, U, L, P, Misses), Left)
    ->  true
    ;   call(Target:First, Thing, Parts)
    ).

not_behind(none, _, _).
not_behind(best(key(BestOrder, BestLacking, BestF, BestTotal, _, _, _, _), _, _),
           tally(H, F, U, _, _, Misses), Left) :-
    ( F > 0 -> Order = 2 ; U > 0 -> Order = 1 ; Order = 0 ),
    (   Order < BestOrder
    ->  true
    ;   Order =:= BestOrder,
        Lacking is -(H + Left),
        (   Lacking < BestLacking
        ->  true
        ;   Lacking =:= BestLacking,
            (   F < BestF
            ->  true
            ;   F =:= BestF,
                total(Misses, Total),
                Total =< BestTotal + 1  % sums in another order may round otherwise
            )
        )
    ).
