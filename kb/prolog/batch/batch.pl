:- module(facetlog_batch, [ encoded_verdicts/4,   % +Target, +Facts, +Inferences, -Encoded
                            brief_verdicts/3,     % +Target, +Inferences, -Verdicts
                            joined_fields/2,      % +Fields, -Encoded
                            part_fields/3,        % +Part, -Fields, ?Rest
                            batch_conditions/2    % +Target, -Models
                          ]).

/** <module> Brief verdicts on one scene after the other

The facts of the scene at hand are put into the module of the specialised rules (code.pl) itself. A brief
verdict is

    brief(Model, Thing, State, Low, High, Parts, Sizes, Cost)

with the same values as in the verdict of judge.pl, whose other arguments it lacks; what is refused has no
degree, no parts and no sizes, for nobody has looked what comes nearest. Cost is
cost(Candidates, Inferences, Seconds): how many assignments were proposed, or which limit was reached,
`stacks` or `inferences`, and what the verdict took, in seconds of processor time.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog_kb(code)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(specialise)).
:- use_module(facetlog_kb(model_descriptions)).
:- use_module(facetlog_kb(facts_on_demand)).

%!  encoded_verdicts(+Target, +Facts, +Inferences, -Encoded) is det.
%
%   Encoded is brief_verdicts/3 on the facts of the text Facts (facts_on_demand.pl): one string, which
%   is written and read faster than terms. It has the atoms and numbers of all verdicts in order, each
%   list after its length and each part after `part` or `group`, with a separator between them; or, if a
%   name has the separator in it, Encoded is the list of them.

encoded_verdicts(Target, Facts, Inferences, Encoded) :-
    await_facts(Target, Facts),
    brief_verdicts(Target, Inferences, Verdicts),
    foldl(fields, Verdicts, Fields, []),
    joined_fields(Fields, Encoded).

%!  joined_fields(+Fields, -Encoded) is det.

joined_fields(Fields, Encoded) :-
    separator(Separator),
    atomic_list_concat(Fields, Separator, Text),
    (   atomic_list_concat(Split, Separator, Text),
        same_length(Split, Fields)
    ->  atom_string(Text, Encoded)
    ;   Encoded = Fields
    ).

separator('\x7f\').     % as in batch_judge.py; no JSON escapes it

fields(brief(Model, Thing, State, Low, High, Parts, Sizes, cost(Candidates, Inferences, Seconds)),
       [Model, Thing, State, Low, High, Candidates, Inferences, Seconds, PartCount|Fields], Rest) :-
    length(Parts, PartCount),
    foldl(part_fields, Parts, Fields, [SizeCount|SizeFields]),
    length(Sizes, SizeCount),
    foldl(size_fields, Sizes, SizeFields, Rest).

%!  part_fields(+Part, -Fields, ?Rest) is det.

part_fields(group(Role, Names), [group, Role, Count|Fields], Rest) :-
    length(Names, Count),
    append(Names, Rest, Fields).
part_fields(Role-Part, Fields, Rest) :-
    (   is_list(Part)
    ->  part_fields(group(Role, Part), Fields, Rest)
    ;   Fields = [part, Role, Part|Rest]
    ).

size_fields(size(Name, V, Sd), [Name, V, Sd|Rest], Rest).

%!  brief_verdicts(+Target, +Inferences, -Verdicts) is det.
%
%   On each thing of the scene at hand each model's, in their orders. All together take no more than
%   most of the Inferences, and one of them no more than a share: who needs more is unknown, and those
%   after it are judged.

most_of(0.9).           % the rest is for all that is no judging
share_of_one(0.1).

brief_verdicts(Target, Inferences, Verdicts) :-
    statistics(inferences, Begun),
    most_of(Most),
    share_of_one(Share),
    End is Begun + integer(Most*Inferences),
    One is integer(Share*Inferences),
    b_setval(facetlog_scene, Target),
    findall(Thing, Target:thing(Thing), Things),
    findall(Verdict,
            ( member(Thing, Things),
              code_model(Target, Model, Module),
              brief(Target, Module, Model, Thing, One, End, Verdict) ),
            Verdicts).

brief(Target, Module, Model, Thing, One, End, Verdict) :-
    Verdict = brief(Model, _, _, _, _, _, _, cost(_, Inferences, Seconds)),
    statistics(inferences, Inferences0),
    statistics(cputime, Seconds0),
    Limit is min(One, End - Inferences0),
    (   Limit > 0
    ->  catch(call_with_inference_limit(judged(Target, Module, Model, Thing, Verdict), Limit, Result),
              error(resource_error(stack), _),
              beyond_limit(stacks, Model, Thing, Verdict))
    ;   Result = inference_limit_exceeded
    ),
    (   Result == inference_limit_exceeded
    ->  beyond_limit(inferences, Model, Thing, Verdict)
    ;   true
    ),
    statistics(cputime, Seconds1),
    statistics(inferences, Inferences1),
    Inferences is Inferences1 - Inferences0,
    Seconds is Seconds1 - Seconds0.

%   A thing with hundreds of faces in one place may fill the stacks with one model's assignments, or take
%   longer than anybody waits: only that is unknown then.
beyond_limit(Limit, Model, Thing, brief(Model, Thing, unknown, 0, 1, [], [], cost(Limit, _, _))).

judged(Target, Module, Model, Thing, brief(Model, Of, State, Low, High, Parts, Sizes, cost(Count, _, _))) :-
    found_in(Target, Module, Model, Thing, Count, Found),
    brief_on(Found, Target, Module, Model, Thing, brief(Of, State, Low, High, Parts, Sizes)),
    !.

brief_on(none, _, _, _, Thing, brief(Thing, unknown, 0, 1, [], [])).
brief_on(refused, _, _, _, Thing, brief(Thing, fails, 0, 0, [], [])).
brief_on(found(Of, Parts, _), Target, Module, Model, _, brief(Of, State, Low, High, Roled, Sizes)) :-
    all_outlined(Target, Model, Of, Parts, outline(State, Low, High)),
    roled(Module, Model, Target, Of, Parts, Roled),
    findall(size(Name, V, Sd),
            ( Target:size(Model, Of, Parts, Name, V, Var), Sd is sqrt(Var) ),
            Sizes).

                 /*******************************
                 *       WHAT RUNS HOW          *
                 *******************************/

%!  batch_conditions(+Target, -Models) is det.
%
%   Models has conditions(Model, Count, Interpreted) for each model, in their order: Interpreted are the
%   labels of those of its Count conditions of which some or all is left to the interpreter.

batch_conditions(Target, Models) :-
    findall(conditions(Model, Count, Interpreted),
            ( code_model(Target, Model, Module),
              findall(Label, clause(Module:condition(Model, Label, _, _, _, _), _), Labels),
              length(Labels, Count),
              interpreted(Target, Model, Labels, Interpreted) ),
            Models).

interpreted(Target, Model, Labels, Interpreted) :-
    Target:lines(Model, Names),
    findall(Label,
            ( nth1(Number, Names, Name),
              calls_interpreter(Target, Name/3),
              nth1(Number, Labels, Label) ),
            Interpreted).
