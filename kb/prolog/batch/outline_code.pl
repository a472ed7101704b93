:- module(facetlog_outline_code, [ outline_code/5        % +Mode, +Test, +Context, -Code, -Outline
                                ]).

/** <module> Tests into goals that say how far

As state_code.pl, with degrees and misses.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(measure_code)).
:- use_module(facetlog_kb(from_source_code)).
:- use_module(facetlog_kb(seen_through)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog_kb(evaluate)).
:- use_module(facetlog_kb(counted)).
:- use_module(facetlog_kb(outlines)).
:- use_module(facetlog(vocabulary)).

%!  outline_code(+Mode, +Test, +Context, -Code, -Outline) is det.
%
%   Code works out the Outline of Test, outline(State, Low, High, Miss): as outline/3 of evaluate.pl
%   where Mode is `outline`; with all digits of a proof, and without the miss, where it is `full`.

outline_code(Mode, Test, Context, Code, Outline) :-
    Outline = outline(_, _, _, _),
    (   nonvar(Test),
        outline_of(Test, Mode, Context, Code0, Outline)
    ->  Code = Code0
    ;   Context = context(Module, _, _),
        no_models(Test),
        asks_all(Context),
        (   Mode == outline
        ->  Code = facetlog_evaluate:outline(Test, Module, Outline)
        ;   Outline = outline(S, L, H, 0),
            Code = facetlog_evaluate:evaluate(Test, Module, proof(S, L, H, _, _, _))
        )
    ).

outline_of(Test, _, Context, ( Known -> Compared ; Outline = outline(unknown, 0, 1, 0) ), Outline) :-
    comparison(Test, Measure, Bounds),
    !,
    comparison_code(Measure, Bounds, Context, Known, Margins),
    compared_code(Margins, Measure, Compared, Outline).
outline_of(all([]), _, _, Outline = outline(holds, 1, 1, 0), Outline) :- !.
outline_of(any([]), _, _, Outline = outline(fails, 0, 0, 1), Outline) :- !.
outline_of(all(Tests), Mode, Context, Code, Outline) :-
    is_list(Tests),
    !,
    maplist(outline_in(Mode, Context), Tests, Codes, Outlines),
    ( Mode == full -> maplist(always, Codes, Steps) ; maplist(unless_lost, Codes, Outlines, Steps) ),
    in_turn(Steps, [], facetlog_outlines:all_of(Mode), Outline, Code, Outlines).
outline_of(any(Tests), Mode, Context, Code, Outline) :-
    is_list(Tests),
    !,
    maplist(outline_in(Mode, Context), Tests, Codes, Outlines),
    maplist(unless_won, Codes, Outlines, Steps),
    in_turn(Steps, [], facetlog_outlines:any_of, Outline, Code, Outlines).
outline_of(not(Test), Mode, Context, ( Code, facetlog_outlines:not_of(Asked, Outline) ), Outline) :-
    !,
    outline_code(Mode, Test, Context, Code, Asked).
outline_of(if_known(Test), Mode, Context, ( Code, facetlog_outlines:if_known_of(Asked, Outline) ),
           Outline) :-
    !,
    outline_code(Mode, Test, Context, Code, Asked).
outline_of(implies(Where, Test), Mode, Context,
           ( If,
             (   facetlog_outlines:not_asked(Asked, Outline)
             ->  true
             ;   Then,
                 facetlog_outlines:implies_of(Asked, Wanted, Outline)
             ) ),
           Outline) :-
    !,
    outline_code(Mode, Where, Context, If, Asked),
    outline_code(Mode, Test, Context, Then, Wanted).
outline_of(expect(Weight, Test), Mode, Context,
           ( Code, facetlog_outlines:expected_of(Weight, Crisp, Asked, Outline) ), Outline) :-
    !,
    number(Weight),
    Weight >= 0,
    Weight =< 1,
    Context = context(_, _, Crisp),
    outline_code(Mode, Test, Context, Code, Asked).
outline_of(each(X, List, Test), outline, Context, Code, Outline) :-
    nonvar(List),
    List = from(_, _, _, _, _),
    !,
    each_from_code(X, List, Test, Context, Code, Outline).
outline_of(some(X, List, Test), outline, Context, Code, Outline) :-
    nonvar(List),
    List = from(_, _, _, _, _),
    !,
    some_from_code(X, List, Test, Context, Code, Outline).
outline_of(each_pair(X, Y, List, Test), outline, Context, Code, Outline) :-
    nonvar(List),
    List = from(_, _, _, _, _),
    !,
    each_pair_from_code(X, Y, List, Test, Context, Code, Outline).
outline_of(Test, Mode, Context, Code, Outline) :-
    written_out(Test, Plain),
    !,
    outline_code(Mode, Plain, Context, Code, Outline).
outline_of(each(X, List, Test), Mode, Context,
           ( findall(One, Call, All), facetlog_outlines:all_of(Mode, All, Outline) ),
           Outline) :-
    !,
    one_of(X, List, Test, Fresh, Member),
    outline_code(Mode, Fresh, Context, Code, One),
    called(( Member, Code ), Member-Fresh-One, Context, Call).
outline_of(some(X, List, Test), Mode, Context,
           ( findall(One, Call, All), facetlog_outlines:any_of(All, Outline) ),
           Outline) :-
    !,
    one_of(X, List, Test, Fresh, Member),
    outline_code(Mode, Fresh, Context, Code, One),
    called(( Member, Code ), Member-Fresh-One, Context, Call).
outline_of(each_pair(X, Y, List, Test), Mode, Context,
           ( findall(One, Call, All), facetlog_outlines:all_of(Mode, All, Outline) ),
           Outline) :-
    !,
    two_of(X, Y, List, Test, Fresh, Pair),
    outline_code(Mode, Fresh, Context, Code, One),
    called(( Pair, Code ), Pair-Fresh-One, Context, Call).
outline_of(Test, Mode, Context,
           ( findall(Group, GroupCall, Found),
             facetlog_outlines:counted_of(Bound, Count, Found, Outline) ),
           Outline) :-
    counted_test(Test, Bound, Count, X, Groups, Inner),
    !,
    integer(Count),
    one_of(X, Members, Inner, Fresh, Member),
    outline_code(Mode, Fresh, Context, Code, One),
    called(( Member, Code ), Member-Fresh-One, Context, Call),
    called(( lists:member(Members, Groups),
             findall(One, Call, All),
             facetlog_outlines:any_of(All, Group) ), Groups-Fresh-Group, Context, GroupCall).
outline_of(Test, _, Context, Code, Outline) :-
    known_relation(Test),
    !,
    relation_code(Test, Context, Truth),
    relation_outline(Truth, Code, Outline).
outline_of(Test, Mode, Context, Code, Outline) :-
    meaning_of(Test, Context, Sort, Meaning),
    (   Sort == own
    ->  word_outline(Test, Mode, Context, Meaning, Code, Outline)
    ;   outline_code(Mode, Meaning, Context, Code, Outline)
    ).

counted_test(at_least_of(Count, X, Groups, Test), at_least, Count, X, Groups, Test).
counted_test(at_most_of(Count, X, Groups, Test), at_most, Count, X, Groups, Test).

%   One test after the other, up to one after which the others change nothing.
in_turn([], Done0, Join, Outline, Code, []) :-
    joined(Join, Done0, Outline, Code).
in_turn([step(Asked, Decided)|Steps], Done0, Join, Outline, Code, [One|Outlines]) :-
    Done = [One|Done0],
    in_turn(Steps, Done, Join, Outline, Rest, Outlines),
    (   ( Decided == fail ; Steps == [] )
    ->  Code = ( Asked, Rest )
    ;   joined(Join, Done, Outline, Early),
        Code = ( Asked, ( Decided -> Early ; Rest ) )
    ).

joined(Module:Join0, Done, Outline, Module:Join) :-
    reverse(Done, Outlines),
    Join0 =.. List0,
    append(List0, [Outlines, Outline], List),
    Join =.. List.

always(Code, step(Code, fail)).

unless_lost(Code, One, step(Code, ( One = outline(fails, _, 0, 1) ))).

unless_won(Code, One, step(Code, ( One = outline(holds, 1, _, _) ))).

outline_in(Mode, Context, Test, Code, Outline) :-
    outline_code(Mode, Test, Context, Code, Outline).

word_outline(Test, Mode, Context, Meaning, Code, outline(S, L, H, Miss)) :-
    term_variables(Test, Args),
    copy_term(Args-Test-Meaning, Inputs-HeadTest-HeadMeaning),
    Context = context(Module, _, _),
    append(Inputs, [S1, L1, H1, Miss1], HeadArgs),
    helper(Context, word(Mode, Module, HeadTest), HeadArgs, Head, New),
    (   New == true
    ->  outline_code(Mode, HeadMeaning, Context, Body, outline(S1, L1, H1, Miss1)),
        put_remembered(Context, Head, Inputs, [S1, L1, H1, Miss1], Body)
    ;   true
    ),
    append(Args, [S, L, H, Miss], CallArgs),
    Head =.. [Name|_],
    Code =.. [Name|CallArgs].

relation_outline(settled(Code, Unseen),
                 (   Code
                 ->  Outline = outline(holds, 1, 1, 0)
                 ;   Unseen
                 ->  Outline = outline(unknown, 0, 1, 0)
                 ;   Outline = outline(fails, 0, 0, 1)
                 ), Outline).
relation_outline(either(For, Against),
                 (   For
                 ->  Outline = outline(holds, 1, 1, 0)
                 ;   Against
                 ->  Outline = outline(fails, 0, 0, 1)
                 ;   Outline = outline(unknown, 0, 1, 0)
                 ), Outline).
