:- module(facetlog_misses, [ all_missed/3,        % +Said, -State, -Miss
                             any_missed/3,        % +Said, -State, -Miss
                             missed_two/8,        % +Below, +BelowVar, +Above, +AboveVar, +Scale, +SoFar,
                                                  % -State, -Miss
                             counted_missed/5,    % +Bound, +Count, +Groups, -State, -Miss
                             each_of/5,           % +Names, :Goal, +Said, -State, -Miss
                             each_pair_of/4,      % +Names, :Goal, -State, -Miss
                             some_of/4,           % +Names, :Goal, -State, -Miss
                             of_others/4          % +Rows, +Excluded, +Said, -Said
                           ]).

/** <module> What misses come to

What the goals call that miss_code.pl writes. What was said of a test is m(State, Miss). Nobody is
asked when nothing can change any more.
*/

:- use_module(library(lists)).

:- set_prolog_flag(optimise, true).

:- meta_predicate each_of(+, 2, +, -, -), each_pair_of(+, 3, -, -), some_of(+, 2, -, -).

%!  all_missed(+Said, -State, -Miss) is det.
%!  any_missed(+Said, -State, -Miss) is det.

all_missed(Said, S, Miss) :-
    counted_in(Said, all(holds, 1, []), All),
    come_to(All, S, Miss).

any_missed(Said, S, Miss) :-
    any_of(Said, fails, 1, S, Least),
    ( S == fails -> Miss = Least ; Miss = 0 ).

any_of([], S, Miss, S, Miss).
any_of([m(S1, Miss1)|Said], S0, Miss0, S, Miss) :-
    (   S1 == fails
    ->  Miss2 is min(Miss0, Miss1),
        any_of(Said, S0, Miss2, S, Miss)
    ;   S1 == holds
    ->  S = holds, Miss = 0
    ;   any_of(Said, unknown, Miss0, S, Miss)
    ).

%   all(State, Left, Misses)
counted_in([], All, All).
counted_in([One|Said], All0, All) :-
    count_in(One, All0, All1),
    counted_in(Said, All1, All).

count_in(m(S1, Miss), All0, All) :-
    (   S1 == holds
    ->  All = All0
    ;   All0 = all(S0, Left0, Misses),
        (   S1 == fails
        ->  Left is Left0*(1 - Miss),
            All = all(fails, Left, [Miss|Misses])
        ;   S0 == fails
        ->  All = All0
        ;   All = all(unknown, Left0, Misses)
        )
    ).

%   As joint_miss/2 of evaluate.pl: in order of size, for rounding would tell another order.
come_to(all(S, _, Misses), S, Miss) :-
    (   Misses == []
    ->  Miss = 0
    ;   msort(Misses, Sorted),
        left_over(Sorted, 1, Left),
        ( Left < 1.0e-10 -> Miss = 1 ; Miss is 1 - Left )
    ).

left_over([], Left, Left).
left_over([Miss|Misses], Left0, Left) :-
    Left1 is Left0*(1 - Miss),
    left_over(Misses, Left1, Left).

nothing_left(all(_, Left, _)) :-
    Left < 1.0e-10.

%!  missed_two(+Below, +BelowVar, +Above, +AboveVar, +Scale, +SoFar, -State, -Miss) is det.
%
%   Of a value outside two limits; the arguments as in outlines.pl.

missed_two(B, BV, A, AV, Scale0, SoFar, S, Miss) :-
    (   A < B
    ->  missed(A, AV, Scale0, S, Miss)
    ;   SoFar == true
    ->  S = unknown, Miss = 0
    ;   missed(B, BV, Scale0, S, Miss)
    ).

missed(D, Var, Scale0, fails, Miss) :-
    Scale is max(Scale0, sqrt(Var)),
    ( Scale > 0 -> Miss is -D/(Scale - D) ; Miss = 1 ).

%!  counted_missed(+Bound, +Count, +Groups, -State, -Miss) is det.
%
%   As counted.pl decides of at least, or at most, Count of what was said of groups.

counted_missed(Bound, Count, Groups, S, Miss) :-
    holding(Groups, 0, Holding, 0, Open),
    counted_missed(Bound, Count, Holding, Open, S, Miss).

counted_missed(at_least, Count, Holding, _, S, 0) :-
    ( Holding >= Count -> S = holds ; S = unknown ).
counted_missed(at_most, Count, Holding, Open, S, Miss) :-
    (   Holding > Count
    ->  S = fails, Miss is (Holding - Count)/float(Holding)
    ;   Holding + Open > Count
    ->  S = unknown, Miss = 0
    ;   S = holds, Miss = 0
    ).

holding([], Holding, Holding, Open, Open).
holding([m(S, _)|Groups], Holding0, Holding, Open0, Open) :-
    (   S == holds
    ->  Holding1 is Holding0 + 1, Open1 = Open0
    ;   S == unknown
    ->  Holding1 = Holding0, Open1 is Open0 + 1
    ;   Holding1 = Holding0, Open1 = Open0
    ),
    holding(Groups, Holding1, Holding, Open1, Open).

%!  each_of(+Names, :Goal, +Said, -State, -Miss) is det.
%!  each_pair_of(+Names, :Goal, -State, -Miss) is det.
%!  some_of(+Names, :Goal, -State, -Miss) is det.
%
%   What Goal says of each of Names, or each two of them in order, and what was Said already, together;
%   or what the best of them says.

each_of(Names, Goal, Said, S, Miss) :-
    counted_in(Said, all(holds, 1, []), All0),
    each_asked(Names, Goal, All0, All),
    come_to(All, S, Miss).

each_asked([], _, All, All).
each_asked([Name|Names], Goal, All0, All) :-
    (   nothing_left(All0)
    ->  All = All0
    ;   call(Goal, Name, One),
        count_in(One, All0, All1),
        each_asked(Names, Goal, All1, All)
    ).

each_pair_of(Names, Goal, S, Miss) :-
    each_pair_asked(Names, Goal, all(holds, 1, []), All),
    come_to(All, S, Miss).

each_pair_asked([], _, All, All).
each_pair_asked([Name|Names], Goal, All0, All) :-
    pairs_with(Names, Name, Goal, All0, All1),
    ( nothing_left(All1) -> All = All1 ; each_pair_asked(Names, Goal, All1, All) ).

pairs_with([], _, _, All, All).
pairs_with([Other|Others], Name, Goal, All0, All) :-
    call(Goal, Name, Other, One),
    count_in(One, All0, All1),
    ( nothing_left(All1) -> All = All1 ; pairs_with(Others, Name, Goal, All1, All) ).

some_of(Names, Goal, S, Miss) :-
    some_asked(Names, Goal, fails, 1, S, Least),
    ( S == fails -> Miss = Least ; Miss = 0 ).

some_asked([], _, S, Miss, S, Miss).
some_asked([Name|Names], Goal, S0, Miss0, S, Miss) :-
    call(Goal, Name, m(S1, Miss1)),
    (   S1 == holds
    ->  S = holds, Miss = 0
    ;   S1 == fails
    ->  Miss2 is min(Miss0, Miss1),
        some_asked(Names, Goal, S0, Miss2, S, Miss)
    ;   some_asked(Names, Goal, unknown, Miss0, S, Miss)
    ).

%!  of_others(+Rows, +Excluded, +Said0, -Said) is det.
%
%   What was said in Rows, a list of Name-m(State, Miss), of names that are not excluded, before Said0.

of_others([], _, Said, Said).
of_others([Name-One|Rows], Excluded, Said0, Said) :-
    (   memberchk(Name, Excluded)
    ->  Said = Said1
    ;   Said = [One|Said1]
    ),
    of_others(Rows, Excluded, Said0, Said1).
