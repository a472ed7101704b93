:- module(facetlog_degrees, [ form/4,         % +Test, -Join, -Parts, -Shown
                              start/3,        % +Join, +Want, -Sum
                              settled/3,      % +Join, +Want, +Sum
                              joined/5,       % +Join, +Want, +Sum0, +Said, -Sum
                              together/4,     % +Join, +Want, +Sum, -Said
                              plain/3,        % +Want, +State, -Said
                              either_way/4,   % +Want, +Said, +Said, -Said
                              counted/3,      % +Saids, -Holding, -Open
                              deciding/2      % +Join, -Place
                            ]).

/** <module> The degree of a test from those of its parts, and the forms of tests

Everything that judges a test has it from here: say.pl, which works a test out, prove.pl, which shows
why, and partial.pl, which works it out beforehand for the tests of given models. A form has one row in
each of

  - form/4: its parts, how they are joined, and what a proof shows of it;
  - state/4: the join's three values (Kleene's);
  - degree/5: its bounds of the probability, and the miss.

What is said of a test is said(State, Degree). State is holds, fails or unknown. Who wants the `state`
alone has no degree: it is `none`. Who wants all (`full`) has degree(Low, High, Miss): bounds of the
probability that the true values pass, equal where all was measured; and by how much the test fails,
from 0 (it does not) to 1 (nothing of it is there).

Probabilities of conditions are multiplied (the least error for the box's three angles, against minimum
and sum); alternatives take the greatest. A sum is sum(State, Degree) of the parts so far, and for counts
the list of what was said of each group.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(facetlog_kb(quantities)).

:- set_prolog_flag(optimise, true).

                 /*******************************
                 *             FORMS            *
                 *******************************/

%!  form(+Test, -Join, -Parts, -Shown) is semidet.
%
%   Parts is one of
%
%     - tests(Tests);
%     - over(Variables, List, Test): Test for each element of List, or each two in their order;
%     - groups(Variable, Groups, Test): each group, a list of members that count as one, is what the
%       best of its members is;
%     - closed(Test, Parts): before these Test, whether there are no more groups.
%
%   Shown is what a proof keeps of Test: it does not repeat the parts.
%
%   @error type_error if a count is no whole number, or a weight no number from 0 to 1.

form(all(Tests),              all,            tests(Tests),               all).
form(any(Tests),              any,            tests(Tests),               any).
form(not(Test),               not,            tests([Test]),              not).
form(if_known(Test),          if_known,       tests([Test]),              if_known).
form(implies(Where, Test),    any,            tests([not(Where), Test]),  implies).
form(expect(Weight, Test),    expect(Weight), tests([Test]),              expect(Weight)) :-
    must_be(number, Weight),            % arithmetic would work out what a clause computed
    must_be(between(0.0, 1.0), Weight).
form(each(X, List, Test),     all,            over([X], List, Test),      each(List)).
form(some(X, List, Test),     any,            over([X], List, Test),      some(List)).
form(each_pair(X, Y, List, Test), all,        over([X, Y], List, Test),   each_pair(List)).
form(at_least_of(Count, X, Groups, Test), at_least(Count), groups(X, Groups, Test),
     at_least_of(Count, Groups)) :-
    must_be(nonneg, Count).
form(at_least_in(Count, Closed, X, Groups, Test), at_least_in(Count),
     closed(Closed, groups(X, Groups, Test)), at_least_in(Count, Groups)) :-
    must_be(nonneg, Count).
form(at_most_of(Count, X, Groups, Test), at_most(Count), groups(X, Groups, Test),
     at_most_of(Count, Groups)) :-
    must_be(nonneg, Count).

                 /*******************************
                 *            STATES            *
                 *******************************/

%   state(Join, State0, State1, State): of the parts so far and the next.
state(all, S0, S1, S) :-
    (   S0 == holds
    ->  S = S1
    ;   S1 == holds
    ->  S = S0
    ;   S0 == S1
    ->  S = S0
    ;   S = fails
    ).
state(any, S0, S1, S) :-
    (   S0 == fails
    ->  S = S1
    ;   S1 == fails
    ->  S = S0
    ;   S0 == S1
    ->  S = S0
    ;   S = holds
    ).
state(not, _, S1, S) :-
    (   S1 == holds
    ->  S = fails
    ;   S1 == fails
    ->  S = holds
    ;   S = unknown
    ).
state(if_known, _, S1, S) :-
    ( S1 == unknown -> S = holds ; S = S1 ).
state(expect(_), _, _, holds).

                 /*******************************
                 *            DEGREES           *
                 *******************************/

%   degree(Join, Degree0, State1, Degree1, Degree): the same. Of all the miss is a list until the last,
%   with what it leaves.
degree(all, degree(L0, H0, left(Left0, Misses0)), S1, degree(L1, H1, Miss),
       degree(L, H, left(Left, Misses))) :-
    L is L0*L1,
    H is H0*H1,
    (   S1 == fails
    ->  Left is Left0*(1 - Miss),
        Misses = [Miss|Misses0]
    ;   Left = Left0,
        Misses = Misses0
    ).
degree(any, degree(L0, H0, Miss0), _, degree(L1, H1, Miss1), degree(L, H, Miss)) :-
    L is max(L0, L1),
    H is max(H0, H1),
    Miss is min(Miss0, Miss1).          % 0 unless both fail
degree(not, _, S1, degree(L1, H1, _), degree(L, H, Miss)) :-
    L is 1 - H1,
    H is 1 - L1,
    ( S1 == holds -> Miss = 1 ; Miss = 0 ).
degree(if_known, _, S1, degree(L1, H1, Miss1), degree(L, H, Miss)) :-
    (   S1 == unknown
    ->  L = 1, H = 1, Miss = 0
    ;   L = L1, H = H1, Miss = Miss1
    ).
degree(expect(Weight), _, _, degree(L1, H1, _), degree(L, H, 0)) :-
    (   crisp                           % degrees are not wanted
    ->  L = 1, H = 1
    ;   L is 1 - Weight*(1 - L1),
        H is 1 - Weight*(1 - H1)
    ).

                 /*******************************
                 *             SUMS             *
                 *******************************/

%!  start(+Join, +Want, -Sum) is det.
%
%   What no part comes to.

start(at_least(_), _, []).
start(at_least_in(_), _, []).
start(at_most(_), _, []).
start(all, Want, sum(holds, Degree)) :- start_degree(Want, degree(1, 1, left(1, [])), Degree).
start(any, Want, sum(fails, Degree)) :- start_degree(Want, degree(0, 0, 1), Degree).
start(not, Want, sum(none, Degree)) :- start_degree(Want, degree(0, 1, 0), Degree).
start(if_known, Want, sum(none, Degree)) :- start_degree(Want, degree(0, 1, 0), Degree).
start(expect(_), Want, sum(holds, Degree)) :- start_degree(Want, degree(0, 1, 0), Degree).

start_degree(state, _, none).
start_degree(full, Degree, Degree).

%!  settled(+Join, +Want, +Sum) is semidet.
%
%   No further part can change what is wanted. Of a count all groups are asked; `not` and `if_known`
%   have but one part.

settled(all, Want, sum(S, Degree)) :-
    S == fails,
    settled_all(Want, Degree).
settled(any, Want, sum(S, Degree)) :-
    S == holds,
    settled_any(Want, Degree).
settled(expect(_), Want, _) :- Want == state.

settled_all(state, _).
settled_all(full, degree(_, H, left(Left, _))) :-
    Left < 1.0e-10,
    H < 1.0e-10.                        % search.pl compares whole multiples of 1.0e-9

settled_any(state, _).
settled_any(full, degree(L, _, _)) :-
    L >= 1.

%!  joined(+Join, +Want, +Sum0, +Said, -Sum) is det.
%
%   Sum is Sum0 and what was Said of the next part.

joined(at_least(_), _, Sums, Said, [Said|Sums]).
joined(at_least_in(_), _, Sums, Said, [Said|Sums]).
joined(at_most(_), _, Sums, Said, [Said|Sums]).
joined(all, Want, Sum0, Said, Sum) :- joined_two(Want, all, Sum0, Said, Sum).
joined(any, Want, Sum0, Said, Sum) :- joined_two(Want, any, Sum0, Said, Sum).
joined(not, Want, Sum0, Said, Sum) :- joined_two(Want, not, Sum0, Said, Sum).
joined(if_known, Want, Sum0, Said, Sum) :- joined_two(Want, if_known, Sum0, Said, Sum).
joined(expect(Weight), Want, Sum0, Said, Sum) :-
    joined_two(Want, expect(Weight), Sum0, Said, Sum).

joined_two(state, Join, sum(S0, none), said(S1, none), sum(S, none)) :-
    state(Join, S0, S1, S).
joined_two(full, Join, sum(S0, Degree0), said(S1, Degree1), sum(S, Degree)) :-
    degree(Join, Degree0, S1, Degree1, Degree),
    state(Join, S0, S1, S).

%!  together(+Join, +Want, +Sum, -Said) is det.
%
%   What all parts come to.

together(all, Want, sum(S, Degree0), said(S, Degree)) :- together_all(Want, Degree0, Degree).
together(any, _, sum(S, Degree), said(S, Degree)).
together(not, _, sum(S, Degree), said(S, Degree)).
together(if_known, _, sum(S, Degree), said(S, Degree)).
together(expect(_), _, sum(S, Degree), said(S, Degree)).
together(at_least(Count), Want, Saids, said(S, Degree)) :-
    counted_together(Want, at_least(Count), Saids, S, Degree).
together(at_least_in(Count), Want, Saids, said(S, Degree)) :-
    counted_together(Want, at_least_in(Count), Saids, S, Degree).
together(at_most(Count), Want, Saids, said(S, Degree)) :-
    counted_together(Want, at_most(Count), Saids, S, Degree).

together_all(state, none, none).
together_all(full, degree(L, H, left(_, Misses)), degree(L, H, Miss)) :-
    ( Misses == [] -> Miss = 0 ; joint_miss(Misses, Miss) ).

%   Several misses count more than the worst of them, and never more than 1. They are taken in order
%   of size, for rounding would tell the order of the tests otherwise.
joint_miss(Misses, Miss) :-
    msort(Misses, Sorted),
    left_over(Sorted, 1, Left),
    ( Left < 1.0e-10 -> Miss = 1 ; Miss is 1 - Left ).

left_over([], Left, Left).
left_over([Miss|Misses], Left0, Left) :-
    Left1 is Left0*(1 - Miss),
    left_over(Misses, Left1, Left).

%!  plain(+Want, +State, -Said) is det.
%
%   What is said where nothing was measured.

plain(state, S, said(S, none)).
plain(full, S, said(S, degree(L, H, Miss))) :-
    (   S == holds
    ->  L = 1, H = 1, Miss = 0
    ;   S == fails
    ->  L = 0, H = 0, Miss = 1
    ;   L = 0, H = 1, Miss = 0
    ).

%!  either_way(+Want, +Said1, +Said2, -Said) is det.
%
%   What is said where nobody knows which of two is so.

either_way(state, said(S1, none), said(S2, none), said(S, none)) :-
    same_state(S1, S2, S).
either_way(full, said(S1, degree(L1, H1, Miss1)), said(S2, degree(L2, H2, Miss2)),
           said(S, degree(L, H, Miss))) :-
    same_state(S1, S2, S),
    L is min(L1, L2),
    H is max(H1, H2),
    Miss is min(Miss1, Miss2).          % of what does not fail it is 0

same_state(S1, S2, S) :-
    ( S1 == S2 -> S = S1 ; S = unknown ).

                 /*******************************
                 *            COUNTS            *
                 *******************************/

%   Of at least K groups the K-th best decides, of at most K the one after that. More of a thing may be
%   there than was seen: too few is not known to be too few. A miss by as many as are allowed is a half.
%   Where all groups are known there is no more: what was said of that came first.
counted_together(Want, at_least_in(Count), Saids0, S, Degree) :-
    !,
    once(append(Saids, [said(Closed, _)], Saids0)),
    (   Closed == holds
    ->  Join = at_least_of_all(Count)
    ;   Join = at_least(Count)
    ),
    counted_together(Want, Join, Saids, S, Degree).
counted_together(Want, Join, Saids, S, Degree) :-
    counted(Saids, Holding, Open),
    count_state(Join, Holding, Open, S),
    count_degree(Want, Join, S, Holding, Saids, Degree).

%!  counted(+Saids, -Holding, -Open) is det.
%
%   How many groups hold, and how many may.

counted(Saids, Holding, Open) :-
    include(is_in(holds), Saids, AllHolding),
    include(is_in(unknown), Saids, AllOpen),
    length(AllHolding, Holding),
    length(AllOpen, Open).

is_in(State, said(State, _)).

count_state(at_least(Count), Holding, _, S) :-
    ( Holding >= Count -> S = holds ; S = unknown ).
count_state(at_least_of_all(Count), Holding, Open, S) :-
    (   Holding >= Count
    ->  S = holds
    ;   Holding + Open >= Count
    ->  S = unknown
    ;   S = fails
    ).
count_state(at_most(Count), Holding, Open, S) :-
    (   Holding > Count
    ->  S = fails
    ;   Holding + Open > Count
    ->  S = unknown
    ;   S = holds
    ).

count_degree(state, _, _, _, _, none).
count_degree(full, Join, S, Holding, Saids, degree(Low, High, Miss)) :-
    findall(L, member(said(_, degree(L, _, _)), Saids), Lows),
    findall(H, member(said(_, degree(_, H, _)), Saids), Highs),
    deciding(Join, Place),
    greatest(Place, Lows, L1),
    greatest(Place, Highs, H1),
    count_bounds(Join, S, L1, H1, Low, High),
    count_miss(Join, S, Holding, Miss).

%!  deciding(+Join, -Place) is det.
%
%   Which of the groups, the best first, decides.

deciding(at_least(Count), Count).
deciding(at_least_in(Count), Count).
deciding(at_least_of_all(Count), Count).
deciding(at_most(Count), Place) :- Place is Count + 1.

count_bounds(at_least(_), S, L, H0, L, H) :-
    ( S == unknown -> H = 1 ; H = H0 ).
count_bounds(at_least_of_all(_), _, L, H, L, H).
count_bounds(at_most(_), _, L, H, Low, High) :-
    Low is 1 - H,
    High is 1 - L.

count_miss(at_least(_), _, _, 0).
count_miss(at_least_of_all(Count), S, Holding, Miss) :-
    ( S == fails -> Miss is (Count - Holding)/float(Count) ; Miss = 0 ).
count_miss(at_most(Count), S, Holding, Miss) :-
    ( S == fails -> Miss is (Holding - Count)/float(Holding) ; Miss = 0 ).

%   The greatest of no values is 1, for it is not asked; of too few 0.
greatest(0, _, 1) :- !.
greatest(Place, Values, Value) :-
    sort(0, @>=, Values, Descending),
    ( nth1(Place, Descending, Value0) -> Value = Value0 ; Value = 0 ).
