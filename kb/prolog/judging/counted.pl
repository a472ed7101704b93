:- module(facetlog_counted, [ counted/4,            % +Test, -Bound, -Count, -Groups
                             counted_shown/2,      % +Test, -Shown
                             evaluate_counted/9,   % +Bound, +Count, +Groups, +Module, -State, -Low,
                                                   % -High, -Detail, -Proofs
                             outline_counted/8,    % +Bound, +Count, +Groups, +Module, -State, -Low,
                                                   % -High, -Miss
                             state_counted/5,      % +Bound, +Count, +Groups, +Module, -State
                             decided/6             % +Bound, +Count, +Outlines, -State, -Low, -High
                           ]).

/** <module> Of how many groups a test holds

Bound is at_least or at_most. Groups is a list of lists of Member-Test: members that count as one,
such as the faces of one leg. A group is what the best of its members is. Of at least K groups the
K-th best decides, of at most K the one after that. More of a thing may be there than was seen: too
few is not known to be too few.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(pairs)).
:- use_module(library(error)).
:- use_module(facetlog_kb(evaluate)).

%!  counted(+Test, -Bound, -Count, -Groups) is semidet.
%
%   @error type_error if the count is no whole number or the groups are no list of lists.

counted(at_least_of(Count, X, Groups, Test), at_least, Count, Tests) :-
    group_tests(Count, X, Groups, Test, Tests).
counted(at_most_of(Count, X, Groups, Test), at_most, Count, Tests) :-
    group_tests(Count, X, Groups, Test, Tests).

group_tests(Count, X, Groups, Test, Tests) :-
    must_be(nonneg, Count),
    must_be(list(list), Groups),
    findall(Group,
            ( member(Members, Groups),
              findall(X-Test, member(X, Members), Group) ),
            Tests).

%!  counted_shown(+Test, -Shown) is det.
%
%   Shown is what a proof keeps of Test.

counted_shown(at_least_of(Count, _, Groups, _), at_least_of(Count, Groups)).
counted_shown(at_most_of(Count, _, Groups, _), at_most_of(Count, Groups)).

                 /*******************************
                 *             PROOF            *
                 *******************************/

%!  evaluate_counted(+Bound, +Count, +Groups, +Module, -State, -Low, -High, -Detail, -Proofs) is det.
%
%   Detail and Proofs as evaluate/3 has them.

evaluate_counted(Bound, Count, Groups, Module, State, Low, High,
                 counted(Holding, Open, Deciding), Proofs) :-
    maplist(evaluate_group(Module), Groups, Evaluated),
    maplist(group_outline, Evaluated, Outlines),
    decided(Bound, Count, Outlines, State, Low, High),
    in_state(holds, Outlines, Holding),
    in_state(unknown, Outlines, Open),
    findall(Rank-(Member-Proof),
            ( member(group(_, Members), Evaluated), best_member(Members, Rank, Member, Proof) ),
            Best0),
    keysort(Best0, Best),
    pairs_values(Best, Named),
    pairs_values(Named, Proofs),
    place(Bound, Count, Place),
    ( nth1(Place, Named, Member-_) -> Deciding = Member ; Deciding = none ).

evaluate_group(Module, Tests, group(outline(State, Low, High), Members)) :-
    maplist(evaluate_member(Module), Tests, Members),
    findall(S-L-H, member(_-proof(S, L, H, _, _, _), Members), Values),
    findall(S, member(S-_-_, Values), States),
    findall(L, member(_-L-_, Values), Lows),
    findall(H, member(_-_-H, Values), Highs),
    best_state(States, State),
    max_list([0|Lows], Low),
    max_list([0|Highs], High).

evaluate_member(Module, Member-Test, Member-Proof) :-
    evaluate(Test, Module, Proof).

group_outline(group(Outline, _), Outline).

best_state(States, State) :-
    (   member(State0, [holds, unknown]),
        memberchk(State0, States)
    ->  State = State0
    ;   State = fails
    ).

%   Of members of one rank the first.
best_member(Members, Rank, Member, Proof) :-
    findall(R-(M-P), ( member(M-P, Members), rank(P, R) ), Ranked),
    keysort(Ranked, [Rank-(Member-Proof)|_]).

rank(proof(State, Low, High, _, _, _), rank(Order, LessLow, LessHigh)) :-
    order(State, Order),
    LessLow is -Low,
    LessHigh is -High.

order(holds, 0).
order(unknown, 1).
order(fails, 2).

                 /*******************************
                 *       OUTLINE AND STATE      *
                 *******************************/

%!  outline_counted(+Bound, +Count, +Groups, +Module, -State, -Low, -High, -Miss) is det.
%
%   As outline/3 has them: a miss by as many as are allowed is a half.

outline_counted(Bound, Count, Groups, Module, State, Low, High, Miss) :-
    maplist(outline_group(Module), Groups, Outlines),
    decided(Bound, Count, Outlines, State, Low, High),
    (   State == fails
    ->  in_state(holds, Outlines, Holding),
        Miss is (Holding - Count)/float(Holding)
    ;   Miss = 0
    ).

outline_group(Module, Members, outline(State, Low, High)) :-
    pairs_values(Members, Tests),
    outline(any(Tests), Module, outline(State, Low, High, _)).

%!  state_counted(+Bound, +Count, +Groups, +Module, -State) is det.

state_counted(Bound, Count, Groups, Module, State) :-
    maplist(state_group(Module), Groups, States),
    state_of(Bound, Count, States, State).

state_group(Module, Members, State) :-
    pairs_values(Members, Tests),
    state(any(Tests), Module, State).

                 /*******************************
                 *           DECISION           *
                 *******************************/

%!  decided(+Bound, +Count, +Outlines, -State, -Low, -High) is det.
%
%   Outlines are outline(State, Low, High) of the groups.

decided(Bound, Count, Outlines, State, Low, High) :-
    findall(S, member(outline(S, _, _), Outlines), States),
    findall(L, member(outline(_, L, _), Outlines), Lows),
    findall(H, member(outline(_, _, H), Outlines), Highs),
    state_of(Bound, Count, States, State),
    place(Bound, Count, Place),
    greatest(Place, Lows, L),
    greatest(Place, Highs, H),
    degrees(Bound, State, L, H, Low, High).

%   Which of the groups, the best first, decides.
place(at_least, Count, Count).
place(at_most, Count, Place) :-
    Place is Count + 1.

degrees(at_least, unknown, L, _, L, 1) :- !.
degrees(at_least, _, L, H, L, H).
degrees(at_most, _, L, H, Low, High) :-
    Low is 1 - H,
    High is 1 - L.

state_of(Bound, Count, States, State) :-
    in_state(holds, States, Holding),
    in_state(unknown, States, Open),
    outcome(Bound, Count, Holding, Open, State).

outcome(at_least, Count, Holding, _, State) :-
    ( Holding >= Count -> State = holds ; State = unknown ).
outcome(at_most, Count, Holding, Open, State) :-
    (   Holding > Count
    ->  State = fails
    ;   Holding + Open > Count
    ->  State = unknown
    ;   State = holds
    ).

in_state(State, States, Count) :-
    include(has_state(State), States, Those),
    length(Those, Count).

has_state(State, State) :- !.
has_state(State, outline(State, _, _)).

%   The greatest of no values is 1, for it is not asked; of too few 0.
greatest(0, _, 1) :- !.
greatest(Place, Values, Value) :-
    sort(0, @>=, Values, Descending),
    ( nth1(Place, Descending, Value0) -> Value = Value0 ; Value = 0 ).
