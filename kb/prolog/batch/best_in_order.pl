:- module(facetlog_best_in_order, [ best_in_order/6    % +Blocks, +Target, +Plan, +Lines, -Thing,
                                                      % -Parts
                                  ]).

/** <module> The best assignment, in three rounds

The same order as search.pl has, and so the same best. There the most promising one is asked next, one
condition at a time, as a test is dear; here a test costs less than to keep such a queue. So all are
asked what costs little first, and then, the most promising first, the rest: each until it is seen to
be behind the best so far, and none after the first that is behind it at once. Degrees are worked out
of those alone that nothing else tells apart.
*/

:- use_module(library(lists)).
:- use_module(library(pairs)).
:- use_module(facetlog_kb(search)).
:- use_module(facetlog_kb(specialise)).

:- set_prolog_flag(optimise, true).

%!  best_in_order(+Blocks, +Target, +Plan, +Lines, -Thing, -Parts) is semidet.
%
%   The best in Blocks, sorted lists of Thing-Parts (left_open.pl), by the conditions of Plan and of
%   Lines (specialise.pl). Fails if there are none.

best_in_order(Blocks, Target, Plan, Lines, Thing, Parts) :-
    cheap_first(Plan, Cheap, Dear),
    best_in_blocks(Blocks, asks(Target, Cheap, Dear, Lines), none, Thing-Parts).

%   Best0 is Key-Best of the blocks before, all of which fail, or none.
best_in_blocks([], _, _-Best, Best).
best_in_blocks([Block|Blocks], Asks, Best0, Best) :-
    best_in_block(Block, Asks, Key, Best1),
    (   Key = bound(2, _, _, _)
    ->  ( Best0 = Key0-Other, Key0-Other @< Key-Best1 -> Nearest = Best0 ; Nearest = Key-Best1 ),
        best_in_blocks(Blocks, Asks, Nearest, Best)
    ;   Best = Best1
    ).

best_in_block([First|Candidates], asks(Target, Cheap, Dear, Lines), Key, Best) :-
    left(Dear, Left),
    first_round([First|Candidates], Target, Cheap, Left, Round),
    keysort(Round, Promising),
    second_round(Promising, Target, Dear, Left, none, best(Key, Equals)),
    third_round(Key, Equals, Target, Lines, Best).

cheap_first([], [], []).
cheap_first([Ask|Plan], Cheap, Dear) :-
    (   Ask = ask(_, _, none)
    ->  Cheap = [Ask|Cheap1],
        cheap_first(Plan, Cheap1, Dear)
    ;   Cheap = [],
        Dear = [Ask|Plan]
    ).

                 /*******************************
                 *           TALLIES            *
                 *******************************/

%   tally(Holding, Failing, Unknown, Misses)
tally_all([], Tally, Tally).
tally_all([m(State, Miss)|Said], tally(H0, F0, U0, Misses), Tally) :-
    (   State == holds
    ->  H is H0 + 1,
        tally_all(Said, tally(H, F0, U0, Misses), Tally)
    ;   State == fails
    ->  F is F0 + 1,
        tally_all(Said, tally(H0, F, U0, [Miss|Misses]), Tally)
    ;   U is U0 + 1,
        tally_all(Said, tally(H0, F0, U, Misses), Tally)
    ).

%   The first parts of a key of search.pl: a bound that further conditions can only worsen.
bound(tally(H, F, U, Misses), Left, bound(Order, Lacking, F, Total)) :-
    ( F > 0 -> Order = 2 ; U > 0 -> Order = 1 ; Order = 0 ),
    Lacking is -(H + Left),
    ( Misses == [] -> Total = 0 ; total(Misses, Total) ).

left([], 0).
left([ask(_, Most, _)|_], Most).

                 /*******************************
                 *            ROUNDS            *
                 *******************************/

%   Bound-open(Candidate, Tally) for each.
first_round([], _, _, _, []).
first_round([Candidate|Candidates], Target, Cheap, Left, [Bound-open(Candidate, Tally)|Round]) :-
    Candidate = Thing-Parts,
    asked_all(Cheap, Target, Thing, Parts, tally(0, 0, 0, []), Tally),
    bound(Tally, Left, Bound),
    first_round(Candidates, Target, Cheap, Left, Round).

asked_all([], _, _, _, Tally, Tally).
asked_all([ask(Name, _, _)|Asks], Target, Thing, Parts, Tally0, Tally) :-
    call(Target:Name, Thing, Parts, Said),
    tally_all(Said, Tally0, Tally1),
    asked_all(Asks, Target, Thing, Parts, Tally1, Tally).

%   Best is best(Bound, Candidates), all of which are as good.
second_round([], _, _, _, Best, Best).
second_round([_-open(Candidate, Tally0)|Round], Target, Dear, Left, Best0, Best) :-
    (   not_behind(Best0, Tally0, Left)
    ->  Candidate = Thing-Parts,
        (   asked(Dear, Target, Thing, Parts, Tally0, Best0, Tally)
        ->  bound(Tally, 0, Bound),
            better(Best0, Bound, Candidate, Best1)
        ;   Best1 = Best0
        ),
        second_round(Round, Target, Dear, Left, Best1, Best)
    ;   Best = Best0                    % and so are all that follow
    ).

better(none, Bound, Candidate, best(Bound, [Candidate])).
better(best(Bound0, Equals), Bound, Candidate, Best) :-
    compare(Order, Bound, Bound0),
    (   Order = (<)
    ->  Best = best(Bound, [Candidate])
    ;   Order = (=)
    ->  Best = best(Bound0, [Candidate|Equals])
    ;   Best = best(Bound0, Equals)
    ).

%   Fails as soon as the candidate is seen to be behind the best.
asked([], _, _, _, Tally, _, Tally).
asked([ask(Name, _, First)|Asks], Target, Thing, Parts, Tally0, Best, Tally) :-
    left(Asks, Left),
    in_reach(Best, First, Target, Thing, Parts, Tally0, Left),
    call(Target:Name, Thing, Parts, Said),
    tally_all(Said, Tally0, Tally1),
    not_behind(Best, Tally1, Left),
    asked(Asks, Target, Thing, Parts, Tally1, Best, Tally).

%   Whether it would be behind if the condition fails is known before by how much it fails.
in_reach(none, _, _, _, _, _, _) :- !.
in_reach(_, none, _, _, _, _, _) :- !.
in_reach(Best, First, Target, Thing, Parts, tally(H, F0, U, Misses), Left) :-
    F is F0 + 1,
    (   not_behind(Best, tally(H, F, U, Misses), Left)
    ->  true
    ;   call(Target:First, Thing, Parts)
    ).

not_behind(none, _, _).
not_behind(best(bound(BestOrder, BestLacking, BestF, BestTotal), _), tally(H, F, U, Misses), Left) :-
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

%   Where nothing fails the most probable is the best, else the first.
third_round(_, [Candidate], _, _, Best) :-
    !,
    Best = Candidate.
third_round(bound(2, _, _, _), Equals, _, _, Best) :-
    !,
    sort(Equals, [Best|_]).
third_round(_, Equals, Target, Lines, Best) :-
    improbable(Equals, Target, Lines, Keyed),
    sort(Keyed, [_-Best|_]).

improbable([], _, _, []).
improbable([Thing-Parts|Equals], Target, Lines, [key(L, P)-(Thing-Parts)|Keyed]) :-
    all_outlined(Lines, Target, Thing, Parts, outline(_, Low, High, _)),
    improbability(Low, L),
    improbability(High, P),
    improbable(Equals, Target, Lines, Keyed).
