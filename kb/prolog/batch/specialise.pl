:- module(facetlog_specialise, [ specialised/2,       % +Model, +Context
                                 all_outlines/5,       % +Names, +Target, +Thing, +Parts, -Outlines
                                 all_outlined/5,       % +Target, +Model, +Thing, +Parts, -Outline
                                 together_outlined/5,  % +Names, +Target, +Thing, +Parts, -Outline
                                 all_hopeless/3,       % +Target, +Model, +Candidates
                                 all_hold/4            % +Target, +Model, +Thing, +Parts
                               ]).

/** <module> Rules for one scene after the other

A batch asks the same few models of thousands of scenes. For that a model is specialised once: what its
goals ask of the vocabulary is copied beside it (body_code.pl), each test becomes what is left of
the clauses that say what it means (partial.pl), and every fact is looked up in one module, which holds
one scene at a time. What was found out of a scene once is remembered until the next.

Context is context(Module, Target, Crisp): the rules, the module of the facts and of the new clauses,
and whether values are exact. A condition that cannot be specialised is asked as always, and costs what it
always did; nothing is judged in another way.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(partial)).
:- use_module(facetlog_kb(sources)).
:- use_module(facetlog_kb(degrees)).
:- use_module(facetlog_kb(plan)).

%!  specialised(+Model, +Context) is det.
%
%   Target can judge Model, one of Module, from now on. It has
%
%     - candidate(Model, Thing, Parts), nondet, as the module itself, and in_turn(Model) if they come one after
%       the other in an order that does not depend on that of the facts;
%     - plan(Model, Plan), as plan/3 has it, with group(Target, Name, Most) for one label or several:
%       Name(Thing, Parts, Outlines) gives the outlines of their conditions;
%     - lines(Model, Names): the same for each condition, in the order of the file;
%     - cheapest(Model, Names): the same, the cheapest first;
%     - group(Model, Thing, Parts, Role, Members), nondet;
%     - size(Model, Thing, Parts, Name, Value, Variance), nondet.
%
specialised(Model, Context) :-
    current_prolog_flag(optimise, Before),
    setup_call_cleanup(
        set_prolog_flag(optimise, true),    % arithmetic is most of the work
        model_code(Context, Model),
        set_prolog_flag(optimise, Before)).

model_code(Context, Model) :-
    Context = context(Module, _, _),
    candidate_code(Context, Model),
    findall(line(Label, LineThing, LineParts, Test, Body),
            clause(Module:condition(Model, Label, _, LineThing, LineParts, Test), Body),
            Lines),
    maplist(line_code(Context, Model), Lines, Names),
    put_clause(Context, lines(Model, Names)),
    plan(Module, Model, Plan0),
    maplist(one_label, Plan0, Single),
    maplist(group_of_lines(Context, Lines, Names), Single, Cheapest0),
    findall(Name, member(group(_, Name, _), Cheapest0), Cheapest),
    put_clause(Context, cheapest(Model, Cheapest)),
    cheap_together(Plan0, Lines, Plan1),
    maplist(group_of_lines(Context, Lines, Names), Plan1, Plan),
    put_clause(Context, plan(Model, Plan)),
    forall(clause(Module:group(Model, GroupThing, GroupParts, Role, Members), GroupBody),
           group_code(Context, Model, GroupThing, GroupParts, Role, Members, GroupBody)),
    put_clause(Context, (size(Model, _, _, _, _, _) :- fail)),
    forall(clause(Module:size(Model, SizeThing, SizeParts, Name, Measure), SizeBody),
           size_code(Context, Model, SizeThing, SizeParts, Name, Measure, SizeBody)).

%   What the language compiles to proposes what is likely, and only if nothing is what comes near: one after the
%   other, if no more are wanted.
candidate_code(Context, Model) :-
    Context = context(Module, _, _),
    Head = candidate(Model, _, Parts),
    (   findall(Head-Body, clause(Module:Head, Body), [Head-( findall(All, Likely, Found),
                                                              ( Empty -> Distant ; member(One, Same) ) )]),
        Empty == ( Found == [] ),
        All == Parts, One == Parts, Same == Found
    ->  put_seen_through(Context, Head, Module:( Likely *-> true ; Distant )),
        put_clause(Context, in_turn(Model))
    ;   put_seen_through(Context, Head, Module:Head),
        put_clause(Context, (in_turn(Model) :- fail))
    ).

%   Head does what Goal does; what cannot be seen through is called as it is.
put_seen_through(Context, Head, Module:Goal) :-
    (   attempt(Context, facetlog_general(_), body_code(Module:Goal, Context, Code))
    ->  true
    ;   asks_all(Context),
        qualified_call(Module, Goal, Code)
    ),
    put_clause(Context, (Head :- Code)).

                 /*******************************
                 *          CONDITIONS          *
                 *******************************/

%   line_code(Context, Model, Line, Name): Name(Thing, Parts, Outlines).
line_code(Context, Model, Line, Name) :-
    helper(Context, line(Model, Line), [Thing, Parts, Outlines], Head, New),
    functor(Head, Name, _),
    (   New == false                    % a file may repeat a condition
    ->  true
    ;   attempt(Context, facetlog_general(_),
                specialised_line(Context, Model, Line, Thing, Parts, Outlines, Head))
    ->  true
    ;   interpreted_line(Context, Model, Line, Thing, Parts, Outlines, Head)
    ).

%   A condition that asks for verdicts, or whatever else depends on more than the scene.
interpreted_line(Context, Model, line(_, Thing, Parts, Test, Body), Thing, Parts, Outlines, Head) :-
    Context = context(Module, _, _),
    asks_all(Context),
    put_clause(Context,
               (Head :- facetlog_search:outlines(Module, Model, Thing, Test, Body, Outlines), !)),
    no_outlines_else(Context, Thing, Parts, Head).

no_outlines_else(Context, Thing, Parts, Head) :-
    (   Thing-Parts =@= _-_
    ->  true
    ;   functor(Head, Name, 3),
        functor(Other, Name, 3),
        arg(3, Other, []),
        put_clause(Context, Other)
    ).

specialised_line(Context, Model, line(Label, Thing, Parts, Test, Body), Thing, Parts, Outlines, Head) :-
    Context = context(Module, _, _),
    written_body(Module, Body, Goals),
    scope(Thing, Parts, Goals, Scope),
    sources(Goals, Steps0),
    put_off(Steps0, Scope, Context, Test, Steps, LateTest),
    maplist(step_code(Scope, Context), Steps, Codes),
    said_code(LateTest, full, Context, said(State, degree(Low, High, Miss)), Code),
    append(Codes, [Code], All),
    conjunction(All, Goal),
    Outline = outline(State, Low, High, Miss),
    term_variables(Thing-Parts, Given),
    term_variables(Test-Goals, Used),
    include(among(Used), Given, Inputs),
    (   \+ ( member(Step, Steps), \+ always_once(Step, _) )
    ->  Answer = ( Goal, Outlines = [Outline] )
    ;   called(Goal, Given-Outline, Context, Call),
        Answer = findall(Outline, Call, Outlines)
    ),
    (   few_parts(Inputs, Parts)
    ->  append(Inputs, [Outlines], KeptArgs),
        helper(Context, kept(Model, Label, Inputs, Test, Goals), KeptArgs, Kept, New),
        ( New == true -> put_remembered(Context, Kept, Inputs, [Outlines], Answer) ; true ),
        put_clause(Context, (Head :- Kept, !))
    ;   put_clause(Context, (Head :- Answer, !))
    ),
    no_outlines_else(Context, Thing, Parts, Head).

%   What does not depend on all parts is asked once for those that it depends on.
few_parts(Inputs, Parts) :-
    Inputs \== [],
    term_variables(Parts, Variables),
    member(Part, Variables),
    \+ among(Inputs, Part).

%   A step that succeeds once for certain is put off until the test asks for what it finds.
put_off(Steps0, Scope, Context, Test0, Steps, Test) :-
    reverse(Steps0, Reversed),
    foldl(put_off_step(Scope, Context), Reversed, Test0-[], Test-Steps).

put_off_step(Scope, Context, Step, Test0-Steps0, Test-Steps) :-
    (   always_once(Step, Found),
        \+ mentions(Steps0, Found)
    ->  Steps = Steps0,
        (   mentions(Test0, Found)
        ->  step_code(Scope, Context, Step, Code),
            placed(Test0, Found, Code, Test)
        ;   Test = Test0                % nobody asks for it
        )
    ;   Steps = [Step|Steps0],
        Test = Test0
    ).

always_once(source(_, _, _, _, Xs), Xs).
always_once(separate(_, Groups), Groups) :- var(Groups).

%   As far within the test as one part alone asks for it.
placed(Test0, Found, Code, Test) :-
    (   nonvar(Test0),
        within(Test0, Found, Part, Test, Placed)
    ->  placed(Part, Found, Code, Placed)
    ;   Test = after(Code, Test0)
    ).

within(all(Tests0), Found, Part, all(Tests), Placed) :- one_asks(Tests0, Found, Part, Tests, Placed).
within(any(Tests0), Found, Part, any(Tests), Placed) :- one_asks(Tests0, Found, Part, Tests, Placed).
within(not(Part), _, Part, not(Placed), Placed).
within(if_known(Part), _, Part, if_known(Placed), Placed).
within(expect(Weight, Part), _, Part, expect(Weight, Placed), Placed).
within(implies(Where, Part), Found, Part, implies(Where, Placed), Placed) :-
    \+ mentions(Where, Found).

one_asks(Tests0, Found, Part, Tests, Placed) :-
    is_list(Tests0),
    append(Before, [Part|After], Tests0),
    mentions(Part, Found),
    !,
    \+ mentions(After, Found),
    append(Before, [Placed|After], Tests).

mentions(Term, Variable) :-
    term_variables(Term, Variables),
    among(Variables, Variable).

%   Conditions that search for nothing are asked together: to choose the next costs more than they do.
cheap_together(Plan0, Lines, Plan) :-
    once(( append(Cheap, Dear, Plan0), \+ ( Dear = [Next|_], cheap(Lines, Next) ) )),
    (   Cheap = [group(_, Most)|_]
    ->  maplist(label_of, Cheap, Labels),
        maplist(one_label, Dear, Others),
        Plan = [group(labels(Labels), Most)|Others]
    ;   maplist(one_label, Dear, Plan)
    ).

cheap(Lines, group(label(Label), _)) :-
    \+ ( member(line(Label0, _, _, _, Body), Lines), \+ Label0 \= Label, Body \== true ).

label_of(group(label(Label), _), Label).

one_label(group(label(Label), Most), group(labels([Label]), Most)).

%   The conditions of each group of a plan in one predicate.
group_of_lines(Context, Lines, Names, group(labels(Labels), Most),
               group(Target, Name, Most)) :-
    Context = context(_, Target, _),
    findall(Of,
            ( member(Label, Labels),
              nth1(Number, Lines, line(Label0, _, _, _, _)),
              \+ Label0 \= Label,
              nth1(Number, Names, Of) ),
            Those),
    (   Those = [Name]
    ->  true
    ;   helper(Context, lines(Those), [Thing, Parts, Outlines], Head, _),
        functor(Head, Name, _),
        put_clause(Context, (Head :- facetlog_specialise:all_outlines(Those, Target, Thing, Parts,
                                                                      Outlines)))
    ).

%!  all_outlines(+Names, +Target, +Thing, +Parts, -Outlines) is det.
%
%   What the predicates Names give, one after the other.

all_outlines([], _, _, _, []).
all_outlines([Name|Names], Target, Thing, Parts, Outlines) :-
    call(Target:Name, Thing, Parts, First),
    append(First, Rest, Outlines),
    all_outlines(Names, Target, Thing, Parts, Rest).

%!  all_hopeless(+Target, +Model, +Candidates) is semidet.
%
%   By the conditions of Model each of Candidates, Thing-Parts, fails with a degree of next to nothing.

all_hopeless(Target, Model, Candidates) :-
    Target:cheapest(Model, Names),
    \+ ( member(Thing-Parts, Candidates),
         \+ hopeless(Names, Target, Thing, Parts, so_far(holds, 1)) ).

%   Degrees are multiplied, and what fails does so whatever else holds: neither is made good again.
hopeless([Name|Names], Target, Thing, Parts, SoFar0) :-
    call(Target:Name, Thing, Parts, Outlines),
    foldl(further, Outlines, SoFar0, SoFar),
    (   SoFar = so_far(fails, High),
        least_degree(Least),
        High < Least
    ->  true
    ;   hopeless(Names, Target, Thing, Parts, SoFar)
    ).

least_degree(0.001).

further(outline(S, _, H, _), so_far(S0, High0), so_far(S1, High)) :-
    ( S == fails -> S1 = fails ; S1 = S0 ),
    High is High0*H.

%!  all_hold(+Target, +Model, +Thing, +Parts) is semidet.
%
%   Each condition of Model holds.

all_hold(Target, Model, Thing, Parts) :-
    Target:cheapest(Model, Names),
    \+ ( member(Name, Names),
         call(Target:Name, Thing, Parts, Outlines),
         member(outline(State, _, _, _), Outlines),
         State \== holds ).

%!  all_outlined(+Target, +Model, +Thing, +Parts, -Outline) is det.
%
%   What the conditions of Model come to together, outline(State, Low, High): in the order of the file, in
%   which a proof has them, so that not a digit differs.

all_outlined(Target, Model, Thing, Parts, Outline) :-
    Target:lines(Model, Names),
    together_outlined(Names, Target, Thing, Parts, Outline).

%!  together_outlined(+Names, +Target, +Thing, +Parts, -Outline) is det.
%
%   The same of the conditions whose predicates Names are.

together_outlined(Names, Target, Thing, Parts, outline(State, Low, High)) :-
    all_outlines(Names, Target, Thing, Parts, Outlines),
    start(all, full, Sum0),
    foldl(outline_joined, Outlines, Sum0, Sum),
    together(all, full, Sum, said(State, degree(Low, High, _))).

outline_joined(outline(S, L, H, Miss), Sum0, Sum) :-
    joined(all, full, Sum0, said(S, degree(L, H, Miss)), Sum).

                 /*******************************
                 *       GROUPS AND SIZES       *
                 *******************************/

%   What the conditions go through the groups go through again.
group_code(Context, Model, Thing, Parts, Role, Members, Body) :-
    Context = context(Module, _, _),
    Head = group(Model, Thing, Parts, Role, Members),
    (   attempt(Context, facetlog_general(_), steps_code(Context, Thing, Parts, Body, Code))
    ->  true
    ;   asks_all(Context),
        qualified_call(Module, Body, Code)
    ),
    put_clause(Context, (Head :- Code)).

steps_code(Context, Thing, Parts, Body, Code) :-
    Context = context(Module, _, _),
    written_body(Module, Body, Goals),
    scope(Thing, Parts, Goals, Scope),
    sources(Goals, Steps),
    maplist(step_code(Scope, Context), Steps, Codes),
    conjunction(Codes, Code).

size_code(Context, Model, Thing, Parts, Name, Measure, Body0) :-
    Context = context(Module, _, _),
    written_body(Module, Body0, Goals),
    conjunction(Goals, Written),
    Size = facetlog_quantities:value(Measure, Module, quantity(V, Var, length)),
    (   attempt(Context, facetlog_general(_), body_code(Module:Written, Context, Body))
    ->  asks_all_if_unknown(Measure, Written, Context)
    ;   asks_all(Context),
        qualified_call(Module, Written, Body)
    ),
    put_clause(Context, (size(Model, Thing, Parts, Name, V, Var) :- Body, Size)).

%   Which of several measures it is was worked out while they were sorted: their facts are asked for.
asks_all_if_unknown(Measure, Written, Context) :-
    (   var(Measure),
        sub_goal(longest_first(_, _), Written)
    ->  true
    ;   attempt(Context, facetlog_unknown(_), value_code(Measure, Context, _, _))
    ->  true
    ;   asks_all(Context)
    ).

sub_goal(Goal, Goal).
sub_goal(Goal, (A, B)) :- ( sub_goal(Goal, A) ; sub_goal(Goal, B) ).
