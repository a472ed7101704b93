:- module(facetlog_from_source_code, [ each_from_code/7,       % +X, +From, +Test, +Context, -Code, -State,
                                                              % -Miss
                                      some_from_code/7,       % the same
                                      each_pair_from_code/8   % +X, +Y, and the same
                                    ]).

/** <module> Quantifiers over what a source gives

From is from(X, Goals, Excluded, Test, Scope), a source (sources.pl) of which the list is not needed. A
step of the test that depends on few parts is asked of all that the source may give, once for these
parts, and what it says of each is kept as far as it says anything. The other steps are asked of one
after the other, until nothing more can change.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(seen_through)).
:- use_module(facetlog_kb(sources)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(miss_code)).

%!  each_from_code(+X, +From, +Test, +Context, -Code, -State, -Miss) is det.

each_from_code(X, From, Test, Context, Code, S, Miss) :-
    one_of(X, _, Test, Fresh, lists:member(Y, _)),
    From = from(Z, Goals, Excluded, Possible, Scope),
    ( Fresh = all(Steps), is_list(Steps) -> true ; Steps = [Fresh] ),
    keyed(Steps, Z-Goals-Possible, Scope, Few, Many),
    groups(Few, Groups),
    foldl(table_code(Y, From, Context), Groups, []-true, Known-TablesCode),
    (   Many == []
    ->  Code = ( TablesCode, facetlog_misses:all_missed(Known, S, Miss) )
    ;   ( Many = [Only] -> Whole = Only ; Whole = all(Many) ),
        miss_code(Whole, Context, WholeCode, S1, Miss1),
        closure(Context, [Y, m(S1, Miss1)], Scope, WholeCode, Closure),
        source_code(source(Z, Goals, Excluded, Possible, Xs), Scope, Context, SourceCode),
        Code = ( TablesCode, SourceCode,
                 facetlog_misses:each_of(Xs, Closure, Known, S, Miss) )
    ).

%   Few are Inputs-Step, if they and the source depend on few parts.
keyed([], _, _, [], []).
keyed([Step|Steps], Source, Scope, Few, Many) :-
    Source = Z-Goals-Possible,
    Scope = scope(Thing, Parts, Derived0),
    term_variables(Z-Goals, Own),
    exclude(among(Own), Derived0, Derived),
    (   few_inputs(Goals-Possible-Step, scope(Thing, Parts, Derived), Inputs)
    ->  Few = [Inputs-Step|Few1],
        Many = Many1
    ;   Few = Few1,
        Many = [Step|Many1]
    ),
    keyed(Steps, Source, Scope, Few1, Many1).

step_of(_-Step, Step).

groups([], []).
groups([Inputs-Step|Keyed], [Inputs-[Step|Steps]|Groups]) :-
    partition(same_inputs(Inputs), Keyed, Same, Others),
    maplist(step_of, Same, Steps),
    groups(Others, Groups).

same_inputs(Inputs, Others-_) :- Inputs == Others.

table_code(Y, from(X, Goals, Excluded, Possible, _), Context, Inputs-Steps,
           Known0-Code0, Known-( Code0, Table, facetlog_misses:of_others(Rows, Excluded, Known0, Known) )) :-
    copy_term(Inputs-Y-X-Goals-Possible-Steps, Inputs1-Y1-X1-Goals1-Possible1-Steps1),
    append(Inputs1, [Rows1], Args1),
    Context = context(Module, _, _),
    helper(Context, rows(Module, Inputs1, Y1, X1, Goals1, Possible1, Steps1), Args1, Head, New),
    (   New == true
    ->  all_code(source(X1, Goals1, [], Possible1, _), Inputs1, Context, All, AllCode),
        ( Steps1 = [Only] -> Whole = Only ; Whole = all(Steps1) ),
        miss_code(Whole, Context, WholeCode, S, Miss),
        called(( lists:member(Y1, All), WholeCode, S \== holds ), All-Y1-S-Miss-Inputs1, Context, Call),
        put_remembered(Context, Head, Inputs1, [Rows1],
                       ( AllCode, findall(Y1-m(S, Miss), Call, Rows1) ))
    ;   true
    ),
    Head =.. [Name|_],
    append(Inputs, [Rows], Args),
    Table =.. [Name|Args].

%!  some_from_code(+X, +From, +Test, +Context, -Code, -State, -Miss) is det.

some_from_code(X, from(Z, Goals, Excluded, Possible, Scope), Test, Context, Code, S, Miss) :-
    source_code(source(Z, Goals, Excluded, Possible, Xs), Scope, Context, SourceCode),
    one_of(X, _, Test, Fresh, lists:member(Y, _)),
    miss_code(Fresh, Context, OneCode, S1, Miss1),
    closure(Context, [Y, m(S1, Miss1)], Scope, OneCode, Closure),
    Code = ( SourceCode, facetlog_misses:some_of(Xs, Closure, S, Miss) ).

%!  each_pair_from_code(+X, +Y, +From, +Test, +Context, -Code, -State, -Miss) is det.

each_pair_from_code(X, Y, from(Z, Goals, Excluded, Possible, Scope), Test, Context, Code, S, Miss) :-
    source_code(source(Z, Goals, Excluded, Possible, Xs), Scope, Context, SourceCode),
    two_of(X, Y, _, Test, Fresh, facetlog_outlines:pair_of(_, A, B)),
    miss_code(Fresh, Context, OneCode, S1, Miss1),
    closure(Context, [A, B, m(S1, Miss1)], Scope, OneCode, Closure),
    Code = ( SourceCode, facetlog_misses:each_pair_of(Xs, Closure, S, Miss) ).

%   A closure that lacks the arguments Last and does what Code does.
closure(Context, Last, Scope, Code, Target:Closure) :-
    Context = context(_, Target, _),
    inputs(Code, Scope, Inputs),
    append(Inputs, Last, Args),
    helper(Context, step(Code, Args), Args, Head, New),
    ( New == true -> put_clause(Context, (Head :- Code)) ; true ),
    Head =.. [Name|_],
    Closure =.. [Name|Inputs].
