:- module(facetlog_connectives, [ connective/4,     % +Test, -How, -Shown, -Tests
                                 combine/6,        % +How, +Proofs, -State, -Low, -High, -Detail
                                 both/3,           % +State, +State, -Both
                                 either/3,         % +State, +State, -Either
                                 opposite/6,       % +State, +Low, +High, -State, -Low, -High
                                 opposite_state/2, % +State, -Opposite
                                 expected/5        % +Weight, +Low, +High, -Low, -High
                               ]).

/** <module> What tests say together

Three-valued logic for the states, products and greatest values for the probabilities. evaluate.pl
says what is asked.
*/

:- use_module(library(lists)).
:- use_module(library(error)).
:- use_module(facetlog_kb(quantities)).

:- set_prolog_flag(optimise, true).

%!  connective(+Test, -How, -Shown, -Tests) is semidet.
%
%   Test joins Tests by How; Shown is what a proof keeps of it.

connective(all(Tests), all, all, Tests).
connective(any(Tests), any, any, Tests).
connective(not(Test), not, not, [Test]).
connective(if_known(Test), if_known, if_known, [Test]).
connective(implies(Where, Test), implies, implies, [Where, Test]).
connective(expect(Weight, Test), expect(Weight), expect(Weight), [Test]).
connective(each(X, List, Test), all, each(List), Tests) :-
    findall(Test, member(X, List), Tests).
connective(some(X, List, Test), any, some(List), Tests) :-
    findall(Test, member(X, List), Tests).
connective(each_pair(X, Y, List, Test), all, each_pair(List), Tests) :-
    findall(Test, ( append(_, [X|Rest], List), member(Y, Rest) ), Tests).

%!  combine(+How, +Proofs, -State, -Low, -High, -Detail) is det.
%
%   What the proofs say together, joined by How: all, any, not, if_known, implies or expect(Weight).

combine(all, Proofs, State, Low, High, all) :-
    product(Proofs, holds, 1, 1, State, Low, High).
combine(any, Proofs, State, Low, High, any) :-
    greatest(Proofs, fails, 0, 0, State, Low, High).
combine(not, [proof(S, L, H, _, _, _)], State, Low, High, not) :-
    opposite(S, L, H, State, Low, High).
combine(if_known, [proof(S, L, H, _, _, _)], State, Low, High, Detail) :-
    (   S == unknown
    ->  State = holds, Low = 1, High = 1, Detail = not_asked
    ;   State = S, Low = L, High = H, Detail = if_known
    ).
combine(implies, [proof(S1, L1, H1, _, _, _), proof(S2, L2, H2, _, _, _)], State, Low, High,
        implies) :-
    opposite(S1, L1, H1, S0, L0, H0),
    either(S0, S2, State),
    Low is max(L0, L2),
    High is max(H0, H2).
combine(expect(Weight), [proof(_, L, H, _, _, _)], holds, Low, High, expect(Weight)) :-
    expected(Weight, L, H, Low, High).

product([], S, L, H, S, L, H).
product([proof(S1, L1, H1, _, _, _)|Proofs], S0, L0, H0, S, L, H) :-
    both(S0, S1, S2),
    L2 is L0*L1,
    H2 is H0*H1,
    product(Proofs, S2, L2, H2, S, L, H).

greatest([], S, L, H, S, L, H).
greatest([proof(S1, L1, H1, _, _, _)|Proofs], S0, L0, H0, S, L, H) :-
    either(S0, S1, S2),
    L2 is max(L0, L1),
    H2 is max(H0, H1),
    greatest(Proofs, S2, L2, H2, S, L, H).

%!  opposite(+State0, +Low0, +High0, -State, -Low, -High) is det.

opposite(S, L, H, State, Low, High) :-
    opposite_state(S, State),
    Low is 1 - H,
    High is 1 - L.

%!  expected(+Weight, +Low0, +High0, -Low, -High) is det.
%
%   What a test that is not required leaves of a degree; all of it where degrees are not wanted.

expected(Weight, L, H, Low, High) :-
    must_be(number, Weight),            % arithmetic would work out what a clause computed
    must_be(between(0.0, 1.0), Weight),
    (   crisp
    ->  Low = 1, High = 1
    ;   Low is 1 - Weight*(1 - L),
        High is 1 - Weight*(1 - H)
    ).

%!  both(+State, +State, -Both) is det.
%!  either(+State, +State, -Either) is det.
%!  opposite_state(+State, -Opposite) is det.
%
%   Kleene's three values.

both(holds, State, State).
both(unknown, State, Both) :-
    ( State == fails -> Both = fails ; Both = unknown ).
both(fails, _, fails).

either(fails, State, State).
either(unknown, State, Either) :-
    ( State == holds -> Either = holds ; Either = unknown ).
either(holds, _, holds).

opposite_state(holds, fails).
opposite_state(fails, holds).
opposite_state(unknown, unknown).
