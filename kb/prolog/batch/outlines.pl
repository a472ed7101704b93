:- module(facetlog_outlines, [ compared/6,      % +Margins, +SoFar, -State, -Low, -High, -Miss
                               mostly_inside/4, % +Below, +BelowVar, +Above, +AboveVar
                               all_of/3,        % +Mode, +Outlines, -Outline
                               any_of/2,        % +Outlines, -Outline
                               not_of/2,        % +Outline, -Outline
                               if_known_of/2,   % +Outline, -Outline
                               not_asked/2,     % +Where, -Outline
                               implies_of/3,    % +Where, +Test, -Outline
                               expected_of/4,   % +Weight, +Crisp, +Outline, -Outline
                               counted_of/4,    % +Bound, +Count, +Outlines, -Outline
                               pair_of/3,       % +List, -X, -Y
                               each_of/4,       % +Names, :Goal, +Known, -Outline
                               some_of/3,       % +Names, :Goal, -Outline
                               each_pair_of/3,  % +Names, :Goal, -Outline
                               changing/1,      % +Outline
                               of_others/4      % +Rows, +Excluded, +Outlines, -Outlines
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

%!  all_of(+Mode, +Outlines, -Outline) is det.
%
%   All together. In the mode `outline` it ends where nothing is left, as outline_all/5 does.

all_of(full, Outlines, outline(S, L, H, 0)) :-
    all_full(Outlines, holds, 1, 1, S, L, H).
all_of(outline, Outlines, outline(S, L, H, Miss)) :-
    all_outlined(Outlines, holds, 1, 1, 1, [], S, L, H, Misses),
    ( Misses == [] -> Miss = 0 ; joint_miss(Misses, Miss) ).

all_full([], S, L, H, S, L, H).
all_full([outline(S1, L1, H1, _)|Outlines], S0, L0, H0, S, L, H) :-
    both(S0, S1, S2),
    L2 is L0*L1,
    H2 is H0*H1,
    all_full(Outlines, S2, L2, H2, S, L, H).

%!  each_of(+Names, :Goal, +Known, -Outline) is det.
%!  each_pair_of(+Names, :Goal, -Outline) is det.
%!  some_of(+Names, :Goal, -Outline) is det.
%
%   As all_of/3 in the mode `outline`, or any_of/2, of the outlines Known and of those that Goal gives
%   for each of Names, or each two of them in order. Nobody is asked when nothing can change any more.
%   Goal may give `none` to some_of/3.

:- meta_predicate each_of(+, 2, +, -), each_pair_of(+, 3, -), some_of(+, 2, -).

each_of(Names, Goal, Known, Outline) :-
    counted_in(Known, all(holds, 1, 1, 1, []), All0),
    each_asked(Names, Goal, All0, All),
    outline_of_all(All, Outline).

each_asked([], _, All, All).
each_asked([Name|Names], Goal, All0, All) :-
    (   nothing_left(All0)
    ->  All = All0
    ;   call(Goal, Name, Outline),
        count_in(Outline, All0, All1),
        each_asked(Names, Goal, All1, All)
    ).

each_pair_of(Names, Goal, Outline) :-
    each_pair_asked(Names, Goal, all(holds, 1, 1, 1, []), All),
    outline_of_all(All, Outline).

each_pair_asked([], _, All, All).
each_pair_asked([Name|Names], Goal, All0, All) :-
    pairs_with(Names, Name, Goal, All0, All1),
    ( nothing_left(All1) -> All = All1 ; each_pair_asked(Names, Goal, All1, All) ).

pairs_with([], _, _, All, All).
pairs_with([Other|Others], Name, Goal, All0, All) :-
    call(Goal, Name, Other, Outline),
    count_in(Outline, All0, All1),
    ( nothing_left(All1) -> All = All1 ; pairs_with(Others, Name, Goal, All1, All) ).

counted_in([], All, All).
counted_in([Outline|Outlines], All0, All) :-
    count_in(Outline, All0, All1),
    counted_in(Outlines, All1, All).

%   all(State, Low, High, Left, Misses)
count_in(outline(S1, L1, H1, Miss), all(S0, L0, H0, Left0, Misses0), all(S, L, H, Left, Misses)) :-
    L is L0*L1,
    H is H0*H1,
    (   S1 == holds
    ->  S = S0, Left = Left0, Misses = Misses0
    ;   S1 == fails
    ->  S = fails, Left is Left0*(1 - Miss), Misses = [Miss|Misses0]
    ;   Left = Left0, Misses = Misses0, ( S0 == fails -> S = fails ; S = unknown )
    ).

nothing_left(all(_, _, H, Left, _)) :-
    H < 1.0e-10,
    Left < 1.0e-10.

outline_of_all(all(S, L, H, _, Misses), outline(S, L, H, Miss)) :-
    ( Misses == [] -> Miss = 0 ; joint_miss(Misses, Miss) ).

some_of(Names, Goal, outline(S, L, H, Miss)) :-
    some_asked(Names, Goal, fails, 0, 0, 1, S, L, H, Least),
    ( S == fails -> Miss = Least ; Miss = 0 ).

some_asked([], _, S, L, H, Miss, S, L, H, Miss).
some_asked([Name|Names], Goal, S0, L0, H0, Miss0, S, L, H, Miss) :-
    call(Goal, Name, Outline),
    (   Outline == none
    ->  some_asked(Names, Goal, S0, L0, H0, Miss0, S, L, H, Miss)
    ;   any_outlined([Outline], S0, L0, H0, Miss0, S1, L1, H1, Miss1),
        (   S1 == holds,
            L1 >= 1
        ->  S = S1, L = L1, H = H1, Miss = Miss1
        ;   some_asked(Names, Goal, S1, L1, H1, Miss1, S, L, H, Miss)
        )
    ).

%!  changing(+Outline) is semidet.
%
%   Outline changes what all_of/3 gives for others.

changing(outline(S, L, _, _)) :-
    ( S \== holds -> true ; L < 1 ).

%!  of_others(+Rows, +Excluded, +Outlines0, -Outlines) is det.
%
%   Outlines are those of Rows, a list of Name-Outline, whose names are not excluded, before Outlines0.

of_others([], _, Outlines, Outlines).
of_others([Name-Outline|Rows], Excluded, Outlines0, Outlines) :-
    (   memberchk(Name, Excluded)
    ->  Outlines = Outlines1
    ;   Outlines = [Outline|Outlines1]
    ),
    of_others(Rows, Excluded, Outlines0, Outlines1).

all_outlined([], S, L, H, _, Misses, S, L, H, Misses).
all_outlined([outline(S1, L1, H1, Miss)|Outlines], S0, L0, H0, Left0, Misses0, S, L, H, Misses) :-
    ( S1 == holds -> S2 = S0 ; both(S1, S0, S2) ),
    L2 is L0*L1,
    H2 is H0*H1,
    (   S1 == fails
    ->  Misses1 = [Miss|Misses0],
        Left is Left0*(1 - Miss),
        (   Left < 1.0e-10,
            H2 < 1.0e-10
        ->  S = S2, L = L2, H = H2, Misses = Misses1
        ;   all_outlined(Outlines, S2, L2, H2, Left, Misses1, S, L, H, Misses)
        )
    ;   Left0 < 1.0e-10,
        H2 < 1.0e-10
    ->  S = S2, L = L2, H = H2, Misses = Misses0
    ;   all_outlined(Outlines, S2, L2, H2, Left0, Misses0, S, L, H, Misses)
    ).

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

%   As joint_miss/2 of evaluate.pl: in order of size, for rounding would tell another order.
joint_miss(Misses, Miss) :-
    msort(Misses, Sorted),
    left_over(Sorted, 1, Left),
    ( Left < 1.0e-10 -> Miss = 1 ; Miss is 1 - Left ).

left_over([], Left, Left).
left_over([Miss|Misses], Left0, Left) :-
    Left1 is Left0*(1 - Miss),
    left_over(Misses, Left1, Left).
