:- module(facetlog_miss_code, [ miss_code/5           % +Test, +Context, -Code, -State, -Miss
                             ]).

/** <module> Tests into goals that say how far they miss

To find the best assignment takes the state of each condition and, where it fails, by how much: most
assignments fail, and then degrees decide nothing. So the goals that are written here work out no
degree, and ask nothing whose only effect is on one. State and miss are those of outline/3.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(measure_code)).
:- use_module(facetlog_kb(state_code)).
:- use_module(facetlog_kb(seen_through)).
:- use_module(facetlog_kb(sources)).
:- use_module(facetlog_kb(from_source_code)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog_kb(evaluate)).
:- use_module(facetlog_kb(misses)).
:- use_module(facetlog(vocabulary)).

%!  miss_code(+Test, +Context, -Code, -State, -Miss) is det.
%
%   Code works out State and Miss of Test.

miss_code(Test, Context, Code, S, Miss) :-
    (   nonvar(Test),
        miss_of(Test, Context, Code0, S, Miss)
    ->  Code = Code0
    ;   Context = context(Module, _, _),
        no_models(Test),
        asks_all(Context),
        Code = facetlog_evaluate:outline(Test, Module, outline(S, _, _, Miss))
    ).

miss_of(Test, Context, ( Known -> Compared ; S = unknown, Miss = 0 ), S, Miss) :-
    comparison(Test, Measure, Bounds),
    !,
    comparison_code(Measure, Bounds, Context, Known, Margins),
    missed_code(Margins, Measure, Compared, S, Miss).
miss_of(all(Tests), Context, Code, S, Miss) :-
    is_list(Tests),
    !,
    maplist(said_code(Context), Tests, Codes, Said),
    all_code(Codes, Said, [], S, Miss, Code).
miss_of(any(Tests), Context, Code, S, Miss) :-
    is_list(Tests),
    !,
    maplist(said_code(Context), Tests, Codes, Said),
    any_code(Codes, Said, [], S, Miss, Code).
miss_of(not(Test), Context, ( Possible -> ( Holds -> S = fails, Miss = 1 ; S = unknown, Miss = 0 )
                            ; S = holds, Miss = 0 ), S, Miss) :-
    !,
    once_code(possible, Test, Context, Possible),
    once_code(holds, Test, Context, Holds).
miss_of(after(Steps, Test, Scope), Context, Code, S, Miss) :-
    !,
    maplist(step_code(Scope, Context), Steps, Codes),
    miss_code(Test, Context, Code0, S, Miss),
    append(Codes, [Code0], All),
    conjunction(All, Code).
miss_of(if_known(Test), Context, ( Code, ( S0 == unknown -> S = holds ; S = S0 ) ), S, Miss) :-
    !,
    miss_code(Test, Context, Code, S0, Miss).
miss_of(implies(Where, Test), Context,
        (   If
        ->  Then,
            (   S0 == holds
            ->  S = holds, Miss = 0
            ;   Sure
            ->  S = S0, Miss = Miss0
            ;   S = unknown, Miss = 0
            )
        ;   S = holds, Miss = 0
        ), S, Miss) :-
    !,
    once_code(possible, Where, Context, If),
    once_code(holds, Where, Context, Sure),
    miss_code(Test, Context, Then, S0, Miss0).
miss_of(expect(Weight, _), _, ( S = holds, Miss = 0 ), S, Miss) :-
    !,
    number(Weight),
    Weight >= 0,
    Weight =< 1.
miss_of(each(X, List, Test), Context, Code, S, Miss) :-
    nonvar(List),
    List = from(_, _, _, _, _),
    !,
    each_from_code(X, List, Test, Context, Code, S, Miss).
miss_of(some(X, List, Test), Context, Code, S, Miss) :-
    nonvar(List),
    List = from(_, _, _, _, _),
    !,
    some_from_code(X, List, Test, Context, Code, S, Miss).
miss_of(each_pair(X, Y, List, Test), Context, Code, S, Miss) :-
    nonvar(List),
    List = from(_, _, _, _, _),
    !,
    each_pair_from_code(X, Y, List, Test, Context, Code, S, Miss).
miss_of(Test, Context, Code, S, Miss) :-
    written_out(Test, Plain),
    !,
    miss_code(Plain, Context, Code, S, Miss).
miss_of(each(X, List, Test), Context,
        ( findall(m(S1, Miss1), Call, Said), facetlog_misses:all_missed(Said, S, Miss) ), S, Miss) :-
    !,
    one_of(X, List, Test, Fresh, Member),
    miss_code(Fresh, Context, Code, S1, Miss1),
    called(( Member, Code ), Member-Fresh-S1-Miss1, Context, Call).
miss_of(some(X, List, Test), Context,
        ( findall(m(S1, Miss1), Call, Said), facetlog_misses:any_missed(Said, S, Miss) ), S, Miss) :-
    !,
    one_of(X, List, Test, Fresh, Member),
    miss_code(Fresh, Context, Code, S1, Miss1),
    called(( Member, Code ), Member-Fresh-S1-Miss1, Context, Call).
miss_of(each_pair(X, Y, List, Test), Context,
        ( findall(m(S1, Miss1), Call, Said), facetlog_misses:all_missed(Said, S, Miss) ), S, Miss) :-
    !,
    two_of(X, Y, List, Test, Fresh, Pair),
    miss_code(Fresh, Context, Code, S1, Miss1),
    called(( Pair, Code ), Pair-Fresh-S1-Miss1, Context, Call).
miss_of(Test, Context,
        ( findall(m(SG, MG), GroupCall, Groups),
          facetlog_misses:counted_missed(Bound, Count, Groups, S, Miss) ), S, Miss) :-
    counted_test(Test, Bound, Count, X, List, Inner),
    !,
    integer(Count),
    one_of(X, Members, Inner, Fresh, Member),
    miss_code(Fresh, Context, Code, S1, Miss1),
    called(( Member, Code ), Member-Fresh-S1-Miss1, Context, Call),
    called(( lists:member(Members, List),
             findall(m(S1, Miss1), Call, Said),
             facetlog_misses:any_missed(Said, SG, MG) ), List-Fresh-SG-MG, Context, GroupCall).
miss_of(Test, Context, Code, S, Miss) :-
    known_relation(Test),
    !,
    relation_code(Test, Context, Truth),
    relation_miss(Truth, Code, S, Miss).
miss_of(Test, Context, Code, S, Miss) :-
    meaning_of(Test, Context, Sort, Meaning),
    (   Sort == own
    ->  word_miss(Test, Context, Meaning, Code, S, Miss)
    ;   miss_code(Meaning, Context, Code, S, Miss)
    ).

counted_test(at_least_of(Count, X, Groups, Test), at_least, Count, X, Groups, Test).
counted_test(at_most_of(Count, X, Groups, Test), at_most, Count, X, Groups, Test).

said_code(Context, Test, Code, m(S, Miss)) :-
    miss_code(Test, Context, Code, S, Miss).

%   Quantifiers over sources are seen through here alone: a state asks for their lists.
once_code(Wanted, Test, Context, Code) :-
    (   asks_source(Test)
    ->  miss_code(Test, Context, Code0, S, _),
        ( Wanted == holds -> Code = ( Code0, S == holds ) ; Code = ( Code0, S \== fails ) )
    ;   state_code(Wanted, Test, Context, Code)
    ).

asks_source(Test) :-
    compound(Test),
    (   Test = from(_, _, _, _, _)
    ->  true
    ;   arg(_, Test, Arg),
        asks_source(Arg)
    ->  true
    ).

                 /*******************************
                 *          COMPARISONS         *
                 *******************************/

missed_code(one(below, D, _, _), Measure, ( D >= 0 -> S = holds, Miss = 0 ; S = unknown, Miss = 0 ), S,
            Miss) :-
    so_far_measure(Measure),
    !.
missed_code(one(_, D, Var, Scale0), _,
            (   D >= 0
            ->  S = holds, Miss = 0
            ;   S = fails,
                Scale is max(Scale0, sqrt(Var)),
                ( Scale > 0 -> Miss is -D/(Scale - D) ; Miss = 1 )
            ), S, Miss) :-
    !.
missed_code(two(B, BV, A, AV, Scale0), Measure,
            (   B >= 0,
                A >= 0
            ->  ( facetlog_outlines:mostly_inside(B, BV, A, AV) -> S = holds ; S = unknown ), Miss = 0
            ;   Scale is Scale0,
                facetlog_misses:missed_two(B, BV, A, AV, Scale, SoFar, S, Miss)
            ), S, Miss) :-
    !,
    ( so_far_measure(Measure) -> SoFar = true ; SoFar = false ).
missed_code(Margins, Measure, Code, S, Miss) :-
    compared_code(Margins, Measure, Code, outline(S, _, _, Miss)).

                 /*******************************
                 *          CONNECTIVES         *
                 *******************************/

%   What is missed altogether is not missed more.
all_code([], Said0, Done, S, Miss, Code) :-
    Said0 == [],
    reverse(Done, Said),
    (   Said == []
    ->  Code = ( S = holds, Miss = 0 )
    ;   Said = [m(S0, Miss0)]
    ->  Code = ( S = S0, Miss = Miss0 )
    ;   maplist(holding, Said, Tests),
        conjunction(Tests, AllHold),
        Code = ( AllHold -> S = holds, Miss = 0 ; facetlog_misses:all_missed(Said, S, Miss) )
    ).
all_code([Code1|Codes], [One|Said], Done, S, Miss, Code) :-
    One = m(S1, Miss1),
    all_code(Codes, Said, [One|Done], S, Miss, Rest),
    (   Codes == []
    ->  Code = ( Code1, Rest )
    ;   Code = ( Code1, ( S1 == fails, Miss1 == 1 -> S = fails, Miss = 1 ; Rest ) )
    ).

holding(m(S, _), S == holds).

any_code([], Said0, Done, S, Miss, Code) :-
    Said0 == [],
    reverse(Done, Said),
    (   Said == []
    ->  Code = ( S = fails, Miss = 1 )
    ;   Code = facetlog_misses:any_missed(Said, S, Miss)
    ).
any_code([Code1|Codes], [One|Said], Done, S, Miss, ( Code1, ( S1 == holds -> S = holds, Miss = 0 ; Rest ) )) :-
    One = m(S1, _),
    any_code(Codes, Said, [One|Done], S, Miss, Rest).

                 /*******************************
                 *      RELATIONS AND WORDS     *
                 *******************************/

relation_miss(settled(Code, Unseen),
              (   Code
              ->  S = holds, Miss = 0
              ;   Unseen
              ->  S = unknown, Miss = 0
              ;   S = fails, Miss = 1
              ), S, Miss).
relation_miss(either(For, Against),
              (   For
              ->  S = holds, Miss = 0
              ;   Against
              ->  S = fails, Miss = 1
              ;   S = unknown, Miss = 0
              ), S, Miss).

word_miss(Test, Context, Meaning, Code, S, Miss) :-
    term_variables(Test, Args),
    copy_term(Args-Test-Meaning, Inputs-HeadTest-HeadMeaning),
    Context = context(Module, _, _),
    append(Inputs, [S1, Miss1], HeadArgs),
    helper(Context, word_miss(Module, HeadTest), HeadArgs, Head, New),
    (   New == true
    ->  miss_code(HeadMeaning, Context, Body, S1, Miss1),
        put_remembered(Context, Head, Inputs, [S1, Miss1], Body)
    ;   true
    ),
    append(Args, [S, Miss], CallArgs),
    Head =.. [Name|_],
    Code =.. [Name|CallArgs].
