:- module(facetlog_outlines, [ compared/6,      % +Margins, +SoFar, -State, -Low, -High, -Miss
                               mostly_inside/4, % +Below, +BelowVar, +Above, +AboveVar
                               all_of/2,        % +Outlines, -Outline
                               any_of/2,        % +Outlines, -Outline
                               not_of/2,        % +Outline, -Outline
                               if_known_of/2,   % +Outline, -Outline
                               not_asked/2,     % +Where, -Outline
                               implies_of/3,    % +Where, +Test, -Outline
                               expected_of/4,   % +Weight, +Crisp, +Outline, -Outline
                               counted_of/4,    % +Bound, +Count, +Outlines, -Outline
                               pair_of/3        % +List, -X, -Y
                             ]).

/** <module> What outlines come to

The steps of evaluate.pl, compare.pl and counted.pl on numbers that are at hand. They are called by the
goals that outline_code.pl writes. An outline is outline(State, Low, High, Miss).
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(connectives)).
:- use_module(facetlog_kb(counted)).
:- use_module(facetlog_kb(fading)).

:- set_prolog_flag(optimise, true).

%!  compared(+Margins, +SoFar, -State, -Low, -High, -Miss) is det.
%
%   What a measured value says of its limits; Margins as in measure_code.pl. SoFar is true if more of
%   what was counted may be there.

compared(one(Side, D, Var, Scale0), SoFar, State, Low, High, Miss) :-
    (   Var > 0
    ->  Sum is 1 + 0.5*erfc(-D/sqrt(2*Var)) - 1,
        Degree is max(0.0, min(1.0, Sum))
    ;   D >= 0
    ->  Degree = 1
    ;   Degree = 0.0
    ),
    (   D >= 0
    ->  State = holds, Low = Degree, High = Degree, Miss = 0
    ;   SoFar == true,
        Side == below
    ->  State = unknown, Low = 0, High = 1, Miss = 0
    ;   State = fails, Low = Degree, High = Degree,
        Scale is max(Scale0, sqrt(Var)),
        (   Scale > 0
        ->  Miss is -D/(Scale - D)
        ;   Miss = 1
        )
    ).
compared(two(B, BV, A, AV, Scale), SoFar, State, Low, High, Miss) :-
    within_two(B, BV, A, AV, Degree),
    (   A < B
    ->  settled(above, A, AV, Scale, Degree, SoFar, State, Low, High, Miss)
    ;   settled(below, B, BV, Scale, Degree, SoFar, State, Low, High, Miss)
    ).
compared(fading(one(Side, D, Var, Scale), Width), SoFar, State, Low, High, Miss) :-
    membership_within([margin(Side, D, Var)], Width, Degree),
    settled(Side, D, Var, Scale, Degree, SoFar, State, Low, High, Miss).
compared(fading(two(B, BV, A, AV, Scale), Width), SoFar, State, Low, High, Miss) :-
    membership_within([margin(below, B, BV), margin(above, A, AV)], Width, Degree),
    (   A < B
    ->  settled(above, A, AV, Scale, Degree, SoFar, State, Low, High, Miss)
    ;   settled(below, B, BV, Scale, Degree, SoFar, State, Low, High, Miss)
    ).

%   As outcome/7 and miss/2 of compare.pl.
settled(Side, D, Var, Scale0, Degree, SoFar, State, Low, High, Miss) :-
    (   D < 0
    ->  (   SoFar == true,
            Side == below
        ->  State = unknown, Low = 0, High = 1, Miss = 0
        ;   State = fails, Low = Degree, High = Degree,
            Scale is max(Scale0, sqrt(Var)),
            (   Scale > 0
            ->  Miss is -D/(Scale - D)
            ;   Miss = 1
            )
        )
    ;   Degree < 0.5
    ->  State = unknown, Low = Degree, High = Degree, Miss = 0
    ;   State = holds, Low = Degree, High = Degree, Miss = 0
    ).

within_two(B, BV, A, AV, Degree) :-
    mass(B, BV, MB),
    mass(A, AV, MA),
    Sum0 is 1 + MB - 1,
    Sum is Sum0 + MA - 1,
    Degree is max(0.0, min(1.0, Sum)).

%!  mostly_inside(+Below, +BelowVar, +Above, +AboveVar) is semidet.

mostly_inside(B, BV, A, AV) :-
    within_two(B, BV, A, AV, Degree),
    Degree >= 0.5.

%!  all_of(+Outlines, -Outline) is det.

all_of(Outlines, outline(S, L, H, 0)) :-
    all_full(Outlines, holds, 1, 1, S, L, H).

all_full([], S, L, H, S, L, H).
all_full([outline(S1, L1, H1, _)|Outlines], S0, L0, H0, S, L, H) :-
    both(S0, S1, S2),
    L2 is L0*L1,
    H2 is H0*H1,
    all_full(Outlines, S2, L2, H2, S, L, H).

%!  any_of(+Outlines, -Outline) is det.

any_of(Outlines, outline(S, L, H, Miss)) :-
    any_outlined(Outlines, fails, 0, 0, 1, S, L, H, Least),
    ( S == fails -> Miss = Least ; Miss = 0 ).

any_outlined([], S, L, H, Miss, S, L, H, Miss).
any_outlined([outline(S1, L1, H1, Miss1)|Outlines], S0, L0, H0, Miss0, S, L, H, Miss) :-
    ( S1 == fails -> S2 = S0 ; either(S1, S0, S2) ),
    L2 is max(L0, L1),
    H2 is max(H0, H1),
    ( S1 == fails -> Miss2 is min(Miss0, Miss1) ; Miss2 = Miss0 ),
    any_outlined(Outlines, S2, L2, H2, Miss2, S, L, H, Miss).

%!  not_of(+Outline0, -Outline) is det.

not_of(outline(S0, L0, H0, _), outline(S, L, H, Miss)) :-
    opposite(S0, L0, H0, S, L, H),
    ( S == fails -> Miss = 1 ; Miss = 0 ).

%!  if_known_of(+Outline0, -Outline) is det.

if_known_of(outline(S, L, H, Miss), Outline) :-
    (   S == unknown
    ->  Outline = outline(holds, 1, 1, Miss)
    ;   Outline = outline(S, L, H, Miss)
    ).

%!  not_asked(+Where, -Outline) is semidet.
%
%   What Where does not hold of is not asked further.

not_asked(outline(S0, L0, H0, _), outline(holds, L, H, 0)) :-
    opposite(S0, L0, H0, holds, L, H),
    L >= 1.

%!  implies_of(+Where, +Test, -Outline) is det.

implies_of(outline(S0, L0, H0, _), outline(S2, L2, H2, Miss2), outline(S, L, H, Miss)) :-
    opposite(S0, L0, H0, S1, L1, H1),
    either(S1, S2, S),
    L is max(L1, L2),
    H is max(H1, H2),
    ( S == fails -> Miss = Miss2 ; Miss = 0 ).

%!  expected_of(+Weight, +Crisp, +Outline0, -Outline) is det.

expected_of(_, true, _, outline(holds, 1, 1, 0)) :- !.
expected_of(Weight, _, outline(_, L0, H0, _), outline(holds, L, H, 0)) :-
    L is 1 - Weight*(1 - L0),
    H is 1 - Weight*(1 - H0).

%!  counted_of(+Bound, +Count, +Groups, -Outline) is det.
%
%   Groups are the outlines of the groups.

counted_of(Bound, Count, Groups, outline(State, Low, High, Miss)) :-
    findall(outline(S, L, H), member(outline(S, L, H, _), Groups), Outlines),
    decided(Bound, Count, Outlines, State, Low, High),
    (   State == fails
    ->  holding(Outlines, 0, Holding),
        Miss is (Holding - Count)/float(Holding)
    ;   Miss = 0
    ).

holding([], Count, Count).
holding([outline(S, _, _)|Outlines], Count0, Count) :-
    ( S == holds -> Count1 is Count0 + 1 ; Count1 = Count0 ),
    holding(Outlines, Count1, Count).

%!  pair_of(+List, -X, -Y) is nondet.
%
%   X stands before Y in List.

pair_of([X|List], X, Y) :- member(Y, List).
pair_of([_|List], X, Y) :- pair_of(List, X, Y).
