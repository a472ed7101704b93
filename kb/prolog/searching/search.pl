:- module(facetlog_search, [ start/4,         % +Sought, +Candidates, +Plan, -Queue
                             next_best/4,     % +Sought, +Queue0, -Queue, -Found
                             outlines/6,      % +Module, +Model, +Thing, ?Test, +Goal, -Outlines
                             total/2,         % +Misses, -Total
                             key/3,           % +Sought, +Open, -Key
                             improbability/2, % +Probability, -Whole
                             candidates/4,    % +Target, +Model, +Thing, -Candidates
                             in_all/2         % +Found, -State
                           ]).

/** <module> The best assignments of faces to parts, best first

Conditions are asked one by one, the cheapest first, and always of the assignment that is still the
most promising: its key is a bound that no further condition can better, so the first one of which
nothing is left to ask is the best of all, and most of the others are never asked the costly
questions. What is kept of each is a tally, no proof.

An assignment of which all conditions hold comes before all others; then the most conditions that
hold; the fewest that fail; the least total miss (outline/3), to which each condition adds 1 at most;
the greatest probability, where nothing fails; the names. Neither the order of conditions nor that of
facts is seen. (To count failures first would favour what nothing is known about.)

Who seeks a `miss` has just that order. Who seeks a `verdict` must know first whether anything is left open, for then the thing is not refuted: what does not fail
comes before all that does. Where all fail, both see the same order.
*/

:- use_module(library(lists)).
:- use_module(library(heaps)).
:- use_module(library(pairs)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(say)).
:- use_module(facetlog_kb(in_progress)).

                 /*******************************
                 *             QUEUE            *
                 *******************************/

%!  candidates(+Target, +Model, +Thing, -Candidates) is det.
%
%   Candidates is the sorted list of Thing-Parts that the model proposes.

candidates(Target, Model, Thing, Candidates) :-
    findall(Thing-Parts, Target:candidate(Model, Thing, Parts), Bag),
    sort(Bag, Candidates).

%!  start(+Sought, +Candidates, +Plan, -Queue) is det.
%
%   Each of Candidates with the first of Plan judged: one with nothing judged is always the most
%   promising.

start(Sought, Candidates, Plan, Queue) :-
    findall(Key-Open,
            ( member(Thing-Parts, Candidates),
              ask_next(open(Thing, Parts, tally(0, 0, 0, 1, 1, []), Plan), Open),
              key(Sought, Open, Key) ),
            Pairs),
    list_to_heap(Pairs, Queue).

%!  next_best(+Sought, +Queue0, -Queue, -Found) is semidet.
%
%   Found is found(Thing, Parts, Tally), the best of Queue0; Queue holds the rest. Fails if none is
%   left. Asked for all, they come in the order that asking everything of each would give:
%
%     ==
%     in_turn(Sought, Candidates, Plan, Found) :-
%     %         findall(Key-found(Thing, Parts, Tally),
%                 ( member(Thing-Parts, Candidates), ask_all(Plan, Thing, Parts, Tally),
%                   key(Sought, open(Thing, Parts, Tally, []), Key) ),
%                 Pairs),
%         keysort(Pairs, Sorted),
%         pairs_values(Sorted, All),
%         member(Found, All).
%     ==

next_best(Sought, Queue0, Queue, Found) :-
    get_from_heap(Queue0, _, Open, Queue1),
    go_on(Open, Sought, Queue1, Queue, Found).

go_on(open(Thing, Parts, Tally, []), _, Queue, Queue, found(Thing, Parts, Tally)) :-
    !.
go_on(Open0, Sought, Queue0, Queue, Found) :-
    ask_next(Open0, Open),
    key(Sought, Open, Key),
    !,                          % else each step of a long search would stay on the stack
    (   min_of_heap(Queue0, Least, _),
        Least @< Key
    ->  add_to_heap(Queue0, Key, Open, Queue1),
        next_best(Sought, Queue1, Queue, Found)
    ;   go_on(Open, Sought, Queue0, Queue, Found)
    ).

ask_next(open(Thing, Parts, Tally, []), open(Thing, Parts, Tally, [])).
ask_next(open(Thing, Parts, Tally0, [group(Target, Name, _)|Groups]), open(Thing, Parts, Tally, Groups)) :-
    call(Target:Name, Thing, Parts, Outlines),
    count_all(Outlines, Tally0, Tally).

%!  outlines(+Module, +Model, +Thing, ?Test, +Goal, -Outlines) is det.
%
%   Outlines of Test for each solution of Goal in Module, while Model is judged for Thing.

outlines(Module, Model, Thing, Test, Goal, Outlines) :-
    (   noted(Module, Model, Thing)     % where one thing is judged: most is asked there
    ->  outlines_now(Module, Test, Goal, Outlines)
    ;   while_judging(Module, Model, Thing, outlines_now(Module, Test, Goal, Outlines))
    ).

outlines_now(Module, Test, Goal, Outlines) :-
    findall(Test, Module:Goal, Tests),
    maplist(outline_in(Module), Tests, Outlines).

outline_in(Module, Test, Outline) :-
    outline(Test, Module, Outline).

count_all([], Tally, Tally).
count_all([Outline|Outlines], Tally0, Tally) :-
    count_one(Outline, Tally0, Tally1),
    count_all(Outlines, Tally1, Tally).

count_one(outline(State, L, P, Miss), tally(H0, F0, U0, L0, P0, Misses0),
          tally(H1, F1, U1, L1, P1, Misses1)) :-
    L1 is L0*L,
    P1 is P0*P,
    count_state(State, Miss, H0, F0, U0, Misses0, H1, F1, U1, Misses1).

count_state(holds, _, H0, F, U, Misses, H, F, U, Misses) :- H is H0 + 1.
count_state(unknown, _, H, F, U0, Misses, H, F, U, Misses) :- U is U0 + 1.
count_state(fails, Miss, H, F0, U, Misses, H, F, U, [Miss|Misses]) :- F is F0 + 1.

%!  in_all(+Found, -State) is det.
%
%   What all conditions together say.

in_all(found(_, _, tally(_, Failing, Unknown, _, _, _)), State) :-
    state_of(Failing, Unknown, State).

state_of(Failing, Unknown, State) :-
    (   Failing > 0
    ->  State = fails
    ;   Unknown > 0
    ->  State = unknown
    ;   State = holds
    ).

                 /*******************************
                 *             KEYS             *
                 *******************************/

%!  key(+Sought, +Open, -Key) is det.
%
%   Least is best. No component can shrink when more conditions are asked, so that the key of an
%   assignment half asked is a bound.
key(Sought, open(Thing, Parts, Tally, Groups),
    key(Order, Lacking, F, Total, L, P, Thing, Parts)) :-
    Tally = tally(H, F, U, Low, High, Misses),
    state_of(F, U, State),
    state_order(Sought, State, Order),
    most_left(Groups, Left),
    Lacking is -(H + Left),
    total(Misses, Total),
    (   F > 0
    ->  L = 0, P = 0            % F has grown: the key as a whole has
    ;   improbability(Low, L),
        improbability(High, P)
    ).

state_order(verdict, holds, 0).
state_order(verdict, unknown, 1).
state_order(verdict, fails, 2).
state_order(miss, holds, 0).
state_order(miss, unknown, 1).
state_order(miss, fails, 1).

most_left([], 0).
most_left([group(_, _, Most)|_], Most).

%   Sums and products of floats depend on the order of their terms in the last digits. They are
%   compared as whole multiples of this, far above such a difference and far below any that matters.
resolution(1.0e-9).

%!  improbability(+Probability, -Whole) is det.
%
%   The less probable the greater, in whole steps of the resolution.

improbability(Probability, Whole) :-
    (   Probability > 0
    ->  resolution(Step),
        Whole is round(-log(Probability)/Step)
    ;   Whole = infinite            % an atom: behind all numbers
    ).

%!  total(+Misses, -Total) is det.
%
%   Their sum, in whole steps of the resolution.

total(Misses, Total) :-
    resolution(Step),
    msort(Misses, Sorted),
    sum_list(Sorted, Sum),
    Total is round(Sum/Step).
