:- module(facetlog_trusted, [ load_trusted/4,     % +Path, +Text, +Module, -Warnings
                              unload_trusted/1    % +Module
                            ]).

/** <module> Files that the user trusts

They are ordinary Prolog, with directives, libraries and files of their own. The name in their
:- module line is not used: each file is loaded into a fresh module, so that several knowledge
bases may load it, and a file called after a built-in model does no harm.
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(small_terms)).
:- use_module(facetlog(vocabulary)).

:- dynamic trusted_source/2.            % Module, Source
:- thread_local reported/3.                 % Kind, Line, Text

%!  load_trusted(+Path, +Text, +Module, -Warnings) is det.
%
%   Text is what stands in the file; Warnings are texts that begin with Path:Line.
%
%   @throws rule_faults(Messages)

load_trusted(Path, Text0, Module, Warnings) :-
    without_module_line(Text0, Text),
    set_module(Module:class(temporary)),
    @(use_module(facetlog(vocabulary)), Module),
    @(import(facetlog_scene:fact/1), Module),
    % Beside the file, so that what it loads is found beside it too.
    format(atom(Source), "~w#~w", [Path, Module]),
    assertz(trusted_source(Module, Source)),
    load_text(Source, Module, Text),
    findall(Line-Message, retract(reported(warning, Line, Message)), Warned),
    findall(Line-Message, retract(reported(error, Line, Message)), Failed0),
    ( Failed0 == [] -> incomplete(Module, Failed) ; Failed = Failed0 ),
    (   Failed == []
    ->  placed(Path, Warned, Warnings)
    ;   unload_trusted(Module),
        placed(Path, Failed, Messages),
        throw(rule_faults(Messages))
    ).

load_text(Source, Module, Text) :-
    setup_call_cleanup(
        ( open_string(Text, Stream),
          asserta((user:thread_message_hook(Term, Kind, Lines) :-
                       facetlog_trusted:keep(Source, Term, Kind, Lines)), Hook) ),
        catch(load_files(Module:Source, [stream(Stream), silent(true)]), Error,
              stopped(Error, Stream)),
        ( erase(Hook),
          close(Stream) )).

%   Prolog's complaints are kept instead of printed.
keep(Source, Term, Kind, Lines) :-
    memberchk(Kind, [warning, error]),
    line_of(Source, Term, Line),
    with_output_to(string(Text0), print_message_lines(current_output, '', Lines)),
    plain(Source, Text0, Text),
    assertz(reported(Kind, Line, Text)).

line_of(_, error(syntax_error(_), file(_, Line, _, _)), Line) :- !.
line_of(_, error(syntax_error(_), stream(_, Line, _, _)), Line) :- !.
line_of(_, _, Line) :-
    (   prolog_load_context(term_position, Position)
    ->  stream_position_data(line_count, Position, Line)
    ;   Line = 0
    ).

%   Without the place, which is given apart, and on one line.
plain(Source, Text0, Text) :-
    split_string(Text0, "\n", " \t", Lines),
    findall(Line,
            ( member(Line0, Lines),
              (   sub_string(Line0, _, _, After, Source)
              ->  sub_string(Line0, _, After, 0, Placed),
                  without_numbers(Placed, Line)
              ;   Line = Line0
              ),
              Line \== "" ),
            Said),
    atomic_list_concat(Said, ' ', Text1),
    normalize_space(string(Text), Text1).

without_numbers(Placed, Text) :-
    split_string(Placed, ":", " ", Parts0),
    leading_numbers(Parts0, Parts),
    atomic_list_concat(Parts, ': ', Text1),
    atom_string(Text1, Text).

leading_numbers([Part|Parts0], Parts) :-
    ( Part == "" ; catch(number_string(_, Part), _, fail) ),
    !,
    leading_numbers(Parts0, Parts).
leading_numbers(Parts, Parts).

%   What is no error of Prolog's ends the loading, where the stream is.
stopped(Error, Stream) :-
    line_count(Stream, Line),
    shortened(Error, Short),
    (   Short = error(_, _)
    ->  '$messages':translate_message(Short, Lines, []),
        with_output_to(string(Text0), print_message_lines(current_output, '', Lines)),
        normalize_space(string(Text), Text0)
    ;   format(string(Text), "it throws ~p", [Short])
    ),
    assertz(reported(error, Line, Text)).

placed(_, [], []).
placed(Path, [Line-Text|Reported], [Message|Messages]) :-
    (   Line > 0
    ->  format(string(Message), "~w:~d: ~w", [Path, Line, Text])
    ;   format(string(Message), "~w: ~w", [Path, Text])
    ),
    placed(Path, Reported, Messages).

incomplete(Module, Failed) :-
    findall(0-Text,
            ( member(Name/Arity, [model/3, candidate/3, condition/6]),
              functor(Head, Name, Arity),
              \+ ( current_predicate(Module:Name/Arity),
                   \+ predicate_property(Module:Head, imported_from(_)) ),
              format(string(Text), "a model needs ~w; see docs/model-reference.md", [Name/Arity]) ),
            Failed).

%   Blanks take its place, so that lines and columns stay what they are.
without_module_line(Text0, Text) :-
    (   setup_call_cleanup(
            open_string(Text0, Stream),
            ( catch(read_term(Stream, Term, [subterm_positions(Position)]), _, fail),
              stream_property(Stream, position(Place)),
              stream_position_data(char_count, Place, End) ),
            close(Stream)),
        Term = (:- module(_, _))
    ->  arg(1, Position, Start),
        sub_string(Text0, 0, Start, _, Before),
        Length is End - Start,
        sub_string(Text0, Start, Length, After, Line),
        string_codes(Line, Codes),
        findall(Blank, ( member(Code, Codes), ( Code =:= 0'\n -> Blank = 0'\n ; Blank = 0'\s ) ),
                Blanks),
        string_codes(Blanked, Blanks),
        sub_string(Text0, _, After, 0, Rest),
        atomics_to_string([Before, Blanked, Rest], Text)
    ;   Text = Text0
    ).

atomics_to_string(Parts, Text) :-
    atomic_list_concat(Parts, Atom),
    atom_string(Atom, Text).

%!  unload_trusted(+Module) is semidet.
%
%   Forgets all that the file defined, in every module. Fails if Module is of no trusted file.

unload_trusted(Module) :-
    retract(trusted_source(Module, Source)),
    unload_file(Source),
    % unload_file/1 leaves what Prolog noted of who loads what.
    retractall(system:'$load_context_module'(Source, _, _)),
    retractall(system:'$load_context_module'(_, Module, _)),
    '$destroy_module'(Module).
